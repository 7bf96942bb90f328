#include "raysweep/reconstruct/photo_hull.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

enum class Shown { nothing, something, everywhere };

/// How many of a picture's pixels above and left of a corner show something.
class CoveredPixels {
  public:
    CoveredPixels(const Image& matte, float threshold)
        : width_(matte.width), height_(matte.height), sums_(std::size_t(width_ + 1) * std::size_t(height_ + 1)) {
        for (int y = 0; y < height_; ++y) {
            std::uint32_t row = 0;
            for (int x = 0; x < width_; ++x) {
                row += matte.at(x, y)[3] > threshold;
                sums_[index(x + 1, y + 1)] = sums_[index(x + 1, y)] + row;
            }
        }
        reachesBorder_ =
            width_ < 3 || height_ < 3 || count(1, 1, width_ - 1, height_ - 1) != count(0, 0, width_, height_);
    }

    /// What a rectangle shows. Outside of the picture is something only if the object reaches its border.
    Shown within(double left, double top, double right, double bottom) const {
        const bool leaves = left < 0 || top < 0 || right > width_ || bottom > height_;
        if (leaves && reachesBorder_) return Shown::something;
        const int x0 = int(std::clamp(left, 0.0, double(width_))), y0 = int(std::clamp(top, 0.0, double(height_)));
        const int x1 = int(std::ceil(std::clamp(right, 0.0, double(width_))));
        const int y1 = int(std::ceil(std::clamp(bottom, 0.0, double(height_))));
        const std::uint32_t covered = count(x0, y0, x1, y1);
        if (covered == 0) return Shown::nothing;
        return !leaves && covered == std::uint32_t(x1 - x0) * std::uint32_t(y1 - y0) ? Shown::everywhere
                                                                                     : Shown::something;
    }

  private:
    std::uint32_t count(int x0, int y0, int x1, int y1) const {
        return sums_[index(x1, y1)] + sums_[index(x0, y0)] - sums_[index(x0, y1)] - sums_[index(x1, y0)];
    }
    std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_ + 1) + std::size_t(x); }

    int width_, height_;
    bool reachesBorder_ = false;
    std::vector<std::uint32_t> sums_;
};

class View {
  public:
    const PhotoCamera& camera;
    CoveredPixels covered;

    View(const Photograph& photograph, float threshold)
        : camera(photograph.camera), covered(photograph.matte, threshold) {}

    /// What this picture knows of a ball: that it holds nothing, that every ball in it holds something, or neither.
    Shown within(const Vec3& center, double radius) const {
        const auto seen = project(camera, center);
        const bool orthographic = camera.projection == Camera::Projection::Orthographic;
        if (!seen || (!orthographic && seen->depth <= 1.01 * radius)) return Shown::something;
        Interval x{-radius, radius}, y{-radius, radius};
        if (!orthographic) {
            x = outline((center - camera.position).dot(camera.right), seen->depth, radius);
            y = outline((center - camera.position).dot(camera.down), seen->depth, radius);
        }
        // Lenses stretch what is near their border by little more than a tenth.
        const double stretch = camera.distortion.isNone() ? 1 : 1.25;
        const double across = camera.focalX * stretch, down = camera.focalY * stretch;
        return covered.within(seen->x + across * x.low, seen->y + down * y.low, seen->x + across * x.high,
                              seen->y + down * y.high);
    }

  private:
    struct Interval {
        double low, high;
    };
    /// From where a ball's centre is seen to where its outline is, at distance 1: the tangents from the eye, in the
    /// plane of the optical axis and one side.
    static Interval outline(double aside, double depth, double radius) {
        const double square = depth * depth - radius * radius;
        const double reach = radius * std::sqrt(aside * aside + square), middle = aside * depth;
        return {(middle - reach) / square - aside / depth, (middle + reach) / square - aside / depth};
    }
};

std::vector<View> viewsOf(const std::vector<Photograph>& photographs, float threshold) {
    std::vector<View> views;
    views.reserve(photographs.size());
    for (const Photograph& photograph : photographs) views.emplace_back(photograph, threshold);
    return views;
}

using Undecided = std::vector<const View*>;

/// Whether a ball may hold something. Of `views` those are left that must be asked about smaller balls in it; the one
/// that knew better comes first, because it knows the neighbours as well.
bool mayShow(Undecided& views, const Vec3& center, double radius, Undecided* left = nullptr) {
    if (left) left->clear();
    for (std::size_t n = 0; n < views.size(); ++n) {
        const Shown shown = views[n]->within(center, radius);
        if (shown == Shown::nothing) {
            std::swap(views[0], views[n]);
            return false;
        }
        if (left && shown == Shown::something) left->push_back(views[n]);
    }
    return true;
}

/// The voxels of a brick that may hold something: first all of it is looked at, then cells of 4x4x4, then voxels.
class BrickHull {
  public:
    BrickHull(const std::vector<View>& views, const ReconstructionGrid& grid)
        : grid_(grid), reach_(std::sqrt(3.0) * grid.edge()) {
        for (const View& view : views) all_.push_back(&view);
    }

    VoxelMask mask(const Index3& origin) {
        VoxelMask mask{};
        if (!mayShow(all_, middle(origin, 8), 4.5 * reach_, &inBrick_)) return mask;
        for (int cell = 0; cell < 8; ++cell) {
            const Index3 low = Index3(cell >> 2, cell >> 1 & 1, cell & 1) * 4;
            if (!mayShow(inBrick_, middle(origin + low, 4), 2.5 * reach_, &inCell_)) continue;
            for (int i = 0; i < 64; ++i) {
                const Index3 within = low + Index3(i >> 4, i >> 2 & 3, i & 3), at = origin + within;
                if (at.x >= grid_.dims.x || at.y >= grid_.dims.y || at.z >= grid_.dims.z) continue;
                if (mayShow(inCell_, grid_.voxel(at.x, at.y, at.z), reach_))
                    mask[std::size_t(within.x)] |= std::uint64_t(1) << (within.y << 3 | within.z);
            }
        }
        return mask;
    }

  private:
    Vec3 middle(const Index3& low, int edge) const {
        const double half = 0.5 * (edge - 1);
        return grid_.voxel(low.x + half, low.y + half, low.z + half);
    }

    const ReconstructionGrid& grid_;
    double reach_;  ///< half the diagonal of a cube from neighbour to neighbour
    Undecided all_, inBrick_, inCell_;
};

bool anyBrickNear(const CompositeLayout& layout, const Index3& origin) {
    for (int n = 0; n < 27; ++n)
        if (layout.voxel(origin + Index3(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1) * 8) >= 512) return true;
    return false;
}

/// The voxels of a brick's slice across x that are kept, or have one that is kept beside them in the slice.
/// @param origin of the brick  @param x in [-1,8], of the slice in the brick
std::uint64_t grownSlice(const CompositeLayout& layout, const Index3& origin, int x) {
    constexpr std::uint64_t kFirsts = 0x0101010101010101, kLasts = kFirsts << 7;  // along z, which bytes are
    const auto word = [&](int y, int z) {
        return layout.masks[layout.voxel(origin + Index3(x, 8 * y, 8 * z)) >> 9][std::size_t(x & 7)];
    };
    std::uint64_t rows[3];  // of the bricks before, here and behind along y
    for (int y = -1; y <= 1; ++y) {
        const std::uint64_t here = word(y, 0);
        rows[y + 1] = here | (here << 1 & ~kFirsts) | (here >> 1 & ~kLasts) | (word(y, -1) >> 7 & kFirsts) |
                      (word(y, 1) << 7 & kLasts);
    }
    return rows[1] | rows[1] << 8 | rows[1] >> 8 | rows[0] >> 56 | rows[2] << 56;
}

/// The voxels of a brick that are kept, or have one that is kept among the 26 around them.
VoxelMask grown(const CompositeLayout& layout, const Index3& origin) {
    std::uint64_t slices[10];
    for (int x = -1; x <= 8; ++x) slices[x + 1] = grownSlice(layout, origin, x);
    VoxelMask mask;
    for (std::size_t x = 0; x < 8; ++x) mask[x] = slices[x] | slices[x + 1] | slices[x + 2];
    return mask;
}

}  // namespace

std::vector<MaskedBrick> photoHull(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                                   float threshold) {
    const std::vector<View> views = viewsOf(photographs, threshold);
    const Index3 count((grid.dims.x + 7) / 8, (grid.dims.y + 7) / 8, (grid.dims.z + 7) / 8);
    std::vector<MaskedBrick> bricks(std::size_t(count.x) * std::size_t(count.y) * std::size_t(count.z));
    parallelFor(bricks.size() / std::size_t(count.z), [&](std::size_t column) {
        BrickHull hull(views, grid);
        for (int z = 0; z < count.z; ++z) {
            MaskedBrick& brick = bricks[column * std::size_t(count.z) + std::size_t(z)];
            brick.origin = Index3(int(column) / count.y, int(column) % count.y, z) * 8;
            brick.mask = hull.mask(brick.origin);
        }
    });
    bricks.erase(std::remove_if(bricks.begin(), bricks.end(), [](const auto& b) { return b.mask == VoxelMask{}; }),
                 bricks.end());
    return bricks;
}

std::vector<MaskedBrick> withNeighbours(const std::vector<MaskedBrick>& bricks, const Index3& dims) {
    const CompositeLayout layout = compositeLayout(dims, bricks);
    const Index3 count((dims.x + 7) / 8, (dims.y + 7) / 8, (dims.z + 7) / 8);
    std::vector<MaskedBrick> all(std::size_t(count.x) * std::size_t(count.y) * std::size_t(count.z));
    parallelFor(all.size(), [&](std::size_t b) {
        MaskedBrick& brick = all[b];
        brick.origin = Index3(int(b) / (count.y * count.z), int(b) / count.z % count.y, int(b) % count.z) * 8;
        brick.mask = {};
        if (!anyBrickNear(layout, brick.origin)) return;
        brick.mask = grown(layout, brick.origin);
        for (int i = 0; i < 512; ++i) {
            const Index3 at = brick.origin + Index3(i >> 6, i >> 3 & 7, i & 7);
            if (at.x >= dims.x || at.y >= dims.y || at.z >= dims.z)
                brick.mask[std::size_t(i >> 6)] &= ~(std::uint64_t(1) << (i & 63));
        }
    });
    all.erase(std::remove_if(all.begin(), all.end(), [](const auto& b) { return b.mask == VoxelMask{}; }), all.end());
    return all;
}

}  // namespace raysweep
