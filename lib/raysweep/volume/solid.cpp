#include "raysweep/volume/solid.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/active_values.h"

#include <openvdb/tools/LevelSetUtil.h>

#include <algorithm>

namespace raysweep {

using openvdb::FloatGrid;

namespace {

/// Sets active voxels to `f` of their value. Not tiles: the surface is far from them.
template <class F>
void changeVoxels(FloatGrid& grid, const F& f) {
    for (const auto& block : activeBlocks(grid))
        if (block.leaf) forEachActive(block, [&](float& value, const openvdb::CoordBBox&) { value = f(value); });
}

}  // namespace

FloatGrid::Ptr levelSetToSolid(const FloatGrid& levelSet) {
    FloatGrid::Ptr solid = levelSet.deepCopy();
    const auto voxel = float(levelSet.voxelSize()[0]);
    // The library's ramp lies inside the surface; moved outwards by half a voxel the surface is in its middle.
    changeVoxels(*solid, [&](float distance) { return distance - 0.5f * voxel; });
    openvdb::tools::sdfToFogVolume(*solid, voxel);
    changeVoxels(*solid, [](float density) { return std::min(density, 1.0f); });  // the ramp goes on inside
    if (solid->empty())
        throw InvalidArgument("the level set '" + levelSet.getName() +
                              "' has no inside: no distance in it is negative");
    return solid;
}

}  // namespace raysweep
