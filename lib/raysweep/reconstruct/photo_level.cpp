#include "raysweep/reconstruct/photo_level.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/reconstruct/photo_hull.h"
#include "raysweep/reconstruct/photo_room.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace raysweep {
namespace {

/// What a level's voxels are at a place between them.
class Interpolated {
  public:
    explicit Interpolated(const PhotoLevel& level) : level_(level) {}

    /// @param slopes of the colour, which are set if there are any; may be null
    /// @return colour of what is kept; extinction; and in `most` the largest extinction of the voxels around
    CompositeVoxel at(const Vec3& world, float& most, ColorSlopes* slopes = nullptr) const {
        const Vec3 place = (world - level_.grid.voxel(0, 0, 0)) / level_.grid.edge();
        CompositeVoxel sum;
        float colors = 0;
        most = 0;
        for (int corner = 0; corner < 8; ++corner) {
            float weight = 1;
            Index3 voxel;
            for (int axis = 0; axis < 3; ++axis) {
                const double below = std::floor(place[axis]);
                const bool upper = (corner >> axis & 1) != 0;
                weight *= float(upper ? place[axis] - below : 1 - (place[axis] - below));
                voxel[axis] = int(below) + upper;
            }
            bool inside = true;
            for (int axis = 0; axis < 3; ++axis) inside &= voxel[axis] >= 0 && voxel[axis] < level_.grid.dims[axis];
            if (!inside) continue;
            const std::size_t i = level_.layout.voxel(voxel);
            if (!level_.layout.keeps(i)) continue;
            const CompositeVoxel& v = level_.voxels[i];
            sum.extinction += weight * v.extinction;
            sum.red += weight * v.red;
            sum.green += weight * v.green;
            sum.blue += weight * v.blue;
            colors += weight;
            if (slopes)
                for (int n = 0; n < 9; ++n) slopes->of[n / 3][n % 3] += weight * level_.slopes[i].of[n / 3][n % 3];
            most = std::max(most, v.extinction);
        }
        if (colors > 0) {
            sum.red /= colors;
            sum.green /= colors;
            sum.blue /= colors;
            if (slopes)
                for (int n = 0; n < 9; ++n) slopes->of[n / 3][n % 3] /= colors;
        }
        return sum;
    }

  private:
    const PhotoLevel& level_;
};

/// A level with these voxels; they have no values yet.
PhotoLevel levelOf(const ReconstructionGrid& grid, const std::vector<MaskedBrick>& solid) {
    PhotoLevel level;
    level.grid = grid;
    level.layout = compositeLayout(grid.dims, withNeighbours(solid, grid.dims), solid);
    level.solid.assign(level.layout.brickCount(), {});
    for (const MaskedBrick& brick : solid)
        if (brick.mask != VoxelMask{}) level.solid[level.layout.voxel(brick.origin) / 512] = brick.mask;
    return level;
}

/// Solid voxels beside one that is not.
std::size_t surfaceOf(const PhotoLevel& level) {
    return orderedSum<std::size_t>(level.layout.brickCount() - 1, [&](std::size_t n) {
        std::size_t count = 0;
        for (std::size_t i = (n + 1) * 512; i < (n + 2) * 512; ++i) {
            if (!level.isSolid(i)) continue;
            const Index3 at = level.layout.origins[n + 1] + Index3(int(i >> 6 & 7), int(i >> 3 & 7), int(i & 7));
            bool outside = false;
            for (int side = 0; side < 6; ++side) {
                Index3 beside = at;
                beside[side >> 1] += (side & 1) != 0 ? 1 : -1;
                outside |= !level.isSolid(level.layout.voxel(beside));
            }
            count += outside;
        }
        return count;
    });
}

/// Sets all values to 0.
void clear(PhotoLevel& level, bool directional) {
    level.voxels.assign(level.layout.voxelCount(), {});
    if (directional) level.slopes.assign(level.layout.voxelCount(), {});
    startSteps(level);
}

}  // namespace

void startSteps(PhotoLevel& level) {
    level.gradient.assign(level.voxels.size(), {});
    level.moments.assign(level.voxels.size(), {});
    level.slopeGradient.assign(level.slopes.size(), {});
    level.slopeMoments.assign(level.slopes.size(), {});
}

void forgetSteps(PhotoLevel& level) {
    level.gradient = std::vector<CompositeVoxel>();
    level.moments = std::vector<AdamMoments>();
    level.slopeGradient = std::vector<ColorSlopes>();
    level.slopeMoments = std::vector<SlopeMoments>();
}

PhotoLevel firstLevel(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid, float hullThreshold,
                      int finer, bool directional) {
    PhotoLevel level = levelOf(grid, photoHull(photographs, grid, hullThreshold));
    if (level.layout.brickCount() == 1)
        throw InvalidArgument("the photographs show nothing that all of them could see; check mattes and poses");
    const std::size_t bytes = PhotoLevel::bytesPerVoxel(directional);
    requireRoom(double(level.layout.voxelCount()), bytes);
    // What is left in the finest level is a surface at the least: a fit that cannot end is not begun.
    requireRoom(std::pow(4.0, finer) * double(surfaceOf(level)), bytes);
    clear(level, directional);
    constexpr float kHaze = 0.05f, kGrey = 0.25f;
    forKept(level.layout, [&](std::size_t i, const Index3&) {
        level.voxels[i] = {level.isSolid(i) ? kHaze : 0, kGrey, kGrey, kGrey};
    });
    return level;
}

std::optional<PhotoLevel> finerLevel(const PhotoLevel& coarse, const std::vector<Photograph>& photographs,
                                     const ReconstructionGrid& grid, float hullThreshold, float prune) {
    const Interpolated from(coarse);
    std::vector<MaskedBrick> bricks = photoHull(photographs, grid, hullThreshold);
    parallelFor(bricks.size(), [&](std::size_t b) {
        MaskedBrick& brick = bricks[b];
        for (int i = 0; i < 512; ++i) {
            const Index3 at = brick.origin + Index3(i >> 6, i >> 3 & 7, i & 7);
            float most = 0;
            from.at(grid.voxel(at.x, at.y, at.z), most);
            if (most < prune) brick.mask[std::size_t(i >> 6)] &= ~(std::uint64_t(1) << (i & 63));
        }
    });
    const bool directional = !coarse.slopes.empty();
    PhotoLevel level = levelOf(grid, bricks);
    if (!hasRoom(double(level.layout.voxelCount()), PhotoLevel::bytesPerVoxel(directional))) return std::nullopt;
    clear(level, directional);
    const float finer = float(grid.edge() / coarse.grid.edge());
    forKept(level.layout, [&](std::size_t i, const Index3& at) {
        float most;
        level.voxels[i] = from.at(grid.voxel(at.x, at.y, at.z), most, directional ? &level.slopes[i] : nullptr);
        level.voxels[i].extinction *= level.isSolid(i) ? finer : 0;
    });
    return level;
}

}  // namespace raysweep
