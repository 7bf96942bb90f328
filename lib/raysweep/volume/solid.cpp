#include "raysweep/volume/solid.h"

#include "raysweep/core/error.h"

#include <openvdb/tools/LevelSetUtil.h>

#include <algorithm>

namespace raysweep {

using openvdb::FloatGrid;

FloatGrid::Ptr levelSetToSolid(const FloatGrid& levelSet) {
    FloatGrid::Ptr solid = levelSet.deepCopy();
    const auto voxel = float(levelSet.voxelSize()[0]);
    // The library's ramp lies inside the surface; moved outwards by half a voxel the surface is in its middle.
    for (auto leaf = solid->tree().beginLeaf(); leaf; ++leaf)
        for (auto value = leaf->beginValueOn(); value; ++value) value.setValue(*value - 0.5f * voxel);
    openvdb::tools::sdfToFogVolume(*solid, voxel);
    for (auto leaf = solid->tree().beginLeaf(); leaf; ++leaf)  // the ramp goes on inside
        for (auto value = leaf->beginValueOn(); value; ++value) value.setValue(std::min(*value, 1.0f));
    if (solid->empty())
        throw InvalidArgument("the level set '" + levelSet.getName() +
                              "' has no inside: no distance in it is negative");
    return solid;
}

}  // namespace raysweep
