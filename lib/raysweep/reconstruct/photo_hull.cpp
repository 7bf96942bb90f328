#include "raysweep/reconstruct/photo_hull.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

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

    /// Whether a rectangle shows something. What lies outside of the picture does only if the object reaches its
    /// border.
    bool mayShow(double left, double top, double right, double bottom) const {
        const bool leaves = left < 0 || top < 0 || right > width_ || bottom > height_;
        if (leaves && reachesBorder_) return true;
        const int x0 = int(std::clamp(left, 0.0, double(width_))), y0 = int(std::clamp(top, 0.0, double(height_)));
        const int x1 = int(std::ceil(std::clamp(right, 0.0, double(width_))));
        const int y1 = int(std::ceil(std::clamp(bottom, 0.0, double(height_))));
        return count(x0, y0, x1, y1) > 0;
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

    /// Whether a ball may hold something, as far as this picture knows.
    bool mayShow(const Vec3& center, double radius) const {
        const auto seen = project(camera, center);
        const bool orthographic = camera.projection == Camera::Projection::Orthographic;
        if (!seen || (!orthographic && seen->depth <= 1.01 * radius)) return true;
        Interval x{-radius, radius}, y{-radius, radius};
        if (!orthographic) {
            x = outline((center - camera.position).dot(camera.right), seen->depth, radius);
            y = outline((center - camera.position).dot(camera.down), seen->depth, radius);
        }
        // Lenses stretch what is near their border by little more than a tenth.
        const double stretch = camera.distortion.isNone() ? 1 : 1.25;
        const double across = camera.focalX * stretch, down = camera.focalY * stretch;
        return covered.mayShow(seen->x + across * x.low, seen->y + down * y.low, seen->x + across * x.high,
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

bool mayShow(const std::vector<View>& views, const Vec3& center, double radius) {
    return std::all_of(views.begin(), views.end(), [&](const View& v) { return v.mayShow(center, radius); });
}

}  // namespace

std::vector<MaskedBrick> photoHull(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                                   float threshold) {
    const std::vector<View> views = viewsOf(photographs, threshold);
    const Index3 count((grid.dims.x + 7) / 8, (grid.dims.y + 7) / 8, (grid.dims.z + 7) / 8);
    std::vector<MaskedBrick> bricks(std::size_t(count.x) * std::size_t(count.y) * std::size_t(count.z));
    // Half the diagonal of a cube from neighbour to neighbour.
    const double reach = std::sqrt(3.0) * grid.spacing;
    parallelFor(bricks.size(), [&](std::size_t b) {
        MaskedBrick& brick = bricks[b];
        brick.origin = Index3(int(b) / (count.y * count.z), int(b) / count.z % count.y, int(b) % count.z) * 8;
        brick.mask = {};
        const Vec3 middle = grid.voxel(brick.origin.x + 3.5, brick.origin.y + 3.5, brick.origin.z + 3.5);
        if (!mayShow(views, middle, 4.5 * reach)) return;
        for (int i = 0; i < 512; ++i) {
            const Index3 at = brick.origin + Index3(i >> 6, i >> 3 & 7, i & 7);
            if (at.x >= grid.dims.x || at.y >= grid.dims.y || at.z >= grid.dims.z) continue;
            if (mayShow(views, grid.voxel(at.x, at.y, at.z), reach))
                brick.mask[std::size_t(i >> 6)] |= std::uint64_t(1) << (i & 63);
        }
    });
    bricks.erase(std::remove_if(bricks.begin(), bricks.end(), [](const auto& b) { return b.mask == VoxelMask{}; }),
                 bricks.end());
    return bricks;
}

std::vector<MaskedBrick> withNeighbours(const std::vector<MaskedBrick>& bricks, const Index3& dims) {
    const CompositeLayout layout = compositeLayout(dims, bricks);
    const auto isKept = [&](const Index3& at) {
        const std::size_t i = layout.voxel(at);
        return isSet(layout.masks[i >> 9], int(i >> 6 & 7), int(i >> 3 & 7), int(i & 7));
    };
    const auto isNear = [&](const Index3& at) {
        for (int n = 0; n < 27; ++n)
            if (isKept(at + Index3(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1))) return true;
        return false;
    };
    const Index3 count((dims.x + 7) / 8, (dims.y + 7) / 8, (dims.z + 7) / 8);
    std::vector<MaskedBrick> all(std::size_t(count.x) * std::size_t(count.y) * std::size_t(count.z));
    parallelFor(all.size(), [&](std::size_t b) {
        MaskedBrick& brick = all[b];
        brick.origin = Index3(int(b) / (count.y * count.z), int(b) / count.z % count.y, int(b) % count.z) * 8;
        brick.mask = {};
        bool any = false;
        for (int n = 0; n < 27; ++n)
            any |= layout.voxel(brick.origin + Index3(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1) * 8) >= 512;
        if (!any) return;
        for (int i = 0; i < 512; ++i) {
            const Index3 at = brick.origin + Index3(i >> 6, i >> 3 & 7, i & 7);
            if (at.x < dims.x && at.y < dims.y && at.z < dims.z && isNear(at))
                brick.mask[std::size_t(i >> 6)] |= std::uint64_t(1) << (i & 63);
        }
    });
    all.erase(std::remove_if(all.begin(), all.end(), [](const auto& b) { return b.mask == VoxelMask{}; }), all.end());
    return all;
}

}  // namespace raysweep
