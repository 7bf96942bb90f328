#include "raysweep/formats/stored_grid.h"

#include "raysweep/core/parallel.h"

#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Leaf = openvdb::FloatTree::LeafNodeType;

/// `count` voxels along i from `at` on.
void mapRow(const StoredVolume& volume, const VoxelMapping& mapping, const Index3& at, int count, float* to) {
    withSampleType(volume.type, [&](auto zero) {
        using Sample = decltype(zero);
        const Sample* from = reinterpret_cast<const Sample*>(volume.samples.get()) + volume.index(at.x, at.y, at.z);
        for (int n = 0; n < count; ++n) {
            const double value = double(from[n]) * mapping.scale + mapping.offset;
            to[n] = std::isfinite(double(from[n])) ? float(value) : 0.0f;
        }
    });
}

/// Null if no voxel of the leaf is active.
std::unique_ptr<Leaf> makeLeaf(const StoredVolume& volume, const IndexBox& region, const VoxelMapping& mapping,
                               const Coord& origin) {
    auto leaf = std::make_unique<Leaf>(origin, mapping.background);
    const auto first = [&](int axis) { return std::max(origin[axis], region.low[axis]); };
    const auto last = [&](int axis) { return std::min(origin[axis] + 7, region.high[axis]); };
    const int count = last(0) - first(0) + 1;
    float values[8];
    for (int k = first(2); k <= last(2); ++k) {
        for (int j = first(1); j <= last(1); ++j) {
            mapRow(volume, mapping, Index3(first(0), j, k), count, values);
            for (int n = 0; n < count; ++n)
                if (!(std::abs(values[n] - mapping.background) <= mapping.tolerance))
                    leaf->setValueOn(Leaf::coordToOffset(Coord(first(0) + n, j, k)), values[n]);
        }
    }
    if (leaf->isEmpty()) leaf.reset();
    return leaf;
}

openvdb::math::Transform::Ptr transformOf(const StoredVolume& volume) {
    const auto& s = volume.steps;
    const Vec3& o = volume.origin;
    return openvdb::math::Transform::createLinearTransform(openvdb::Mat4d(
        s[0].x, s[0].y, s[0].z, 0.0, s[1].x, s[1].y, s[1].z, 0.0, s[2].x, s[2].y, s[2].z, 0.0, o.x, o.y, o.z, 1.0));
}

/// Leaves of one layer of the tree, 8 slices, made side by side; full and constant ones become tiles at once, so that
/// a volume that is mostly one value never exists as voxels.
void addLayer(const StoredVolume& volume, const IndexBox& region, const VoxelMapping& mapping, int z,
              openvdb::FloatTree& tree) {
    std::vector<Coord> origins;
    for (int x = region.low.x & ~7; x <= region.high.x; x += 8)
        for (int y = region.low.y & ~7; y <= region.high.y; y += 8) origins.emplace_back(x, y, z);
    std::vector<std::unique_ptr<Leaf>> leaves(origins.size());
    parallelFor(origins.size(), [&](std::size_t n) { leaves[n] = makeLeaf(volume, region, mapping, origins[n]); });
    for (auto& leaf : leaves) {
        float value = 0;
        bool active = false;
        if (!leaf) continue;
        if (leaf->isConstant(value, active) && active)
            tree.addTile(1, leaf->origin(), value, true);
        else
            tree.addLeaf(leaf.release());
    }
}

}  // namespace

FloatGrid::Ptr gridOf(const StoredVolume& volume, const IndexBox& region, const VoxelMapping& mapping,
                      const ProgressCallback& progress) {
    FloatGrid::Ptr grid = FloatGrid::create(mapping.background);
    grid->setTransform(transformOf(volume));
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    const int low = region.low.z & ~7;
    for (int z = low; z <= region.high.z; z += 8) {
        if (!report(progress, "converting", double(z - low) / (region.high.z - low + 1))) return nullptr;
        addLayer(volume, region, mapping, z, grid->tree());
    }
    openvdb::tools::prune(grid->tree());
    return grid;
}

}  // namespace raysweep
