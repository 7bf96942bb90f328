#include "raysweep/volume/overlap.h"

#include "raysweep/volume/grid_transform.h"

namespace raysweep {
namespace {

constexpr double kFurthest = 1e9;         ///< coordinate that can still be counted
constexpr double kParallel = 1e-6;        ///< a slant below this part of an edge is rounding
constexpr double kSmallestVolume = 1e-9;  ///< of a voxel, in cubes of its longest edge

void requireNear(const openvdb::GridBase& from, const openvdb::math::Transform& to) {
    const openvdb::CoordBBox active = from.evalActiveVoxelBoundingBox();
    for (int corner = 0; corner < 8 && !active.empty(); ++corner) {
        openvdb::Vec3d at;
        for (int axis = 0; axis < 3; ++axis) at[axis] = corner >> axis & 1 ? active.max()[axis] : active.min()[axis];
        at = to.worldToIndex(from.indexToWorld(at));
        for (int axis = 0; axis < 3; ++axis)
            if (!(std::abs(at[axis]) < kFurthest))
                throw InvalidArgument("grid '" + from.getName() +
                                      "' lies more than 1e9 voxels of the density away from its origin; are their "
                                      "transforms in the same units?");
    }
}

}  // namespace

Overlap::Overlap(const openvdb::GridBase& from, const openvdb::math::Transform& to) {
    requireLinear(from);
    const auto inLattice = [&](const openvdb::Vec3d& at) { return to.worldToIndex(from.indexToWorld(at)); };
    origin_ = inLattice(openvdb::Vec3d(0.0));
    double longest = 0;
    for (int a = 0; a < 3; ++a) {
        openvdb::Vec3d unit(0.0);
        unit[a] = 1;
        edges_[a] = inLattice(unit) - origin_;
        longest = std::max(longest, edges_[a].length());
        for (int k = 0; k < 3; ++k)
            if (k != a && std::abs(edges_[a][k]) > kParallel * edges_[a].length()) parallel_ = false;
    }
    volumeRatio_ = std::abs(edges_[0].dot(edges_[1].cross(edges_[2])));
    if (!(volumeRatio_ > kSmallestVolume * longest * longest * longest) || !std::isfinite(volumeRatio_))
        throw InvalidArgument("grid '" + from.getName() + "' has a singular transform: its voxels have no volume");
    requireNear(from, to);
}

}  // namespace raysweep
