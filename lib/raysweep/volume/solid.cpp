#include "raysweep/volume/solid.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/grid_select.h"

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
    return solid;
}

FloatGrid::Ptr selectSolid(const VdbFile& file, const std::string& name) {
    // selectDensity refuses level sets, so it is shown all of them as fog; the trees are shared, not copied.
    const std::string mark = "raysweep_level_set";
    VdbFile shown{file.path, {}, file.metadata};
    for (const auto& grid : file.grids) {
        shown.grids.push_back(grid);
        if (grid->getGridClass() != openvdb::GRID_LEVEL_SET) continue;
        shown.grids.back() = grid->copyGrid();
        shown.grids.back()->setGridClass(openvdb::GRID_FOG_VOLUME);
        shown.grids.back()->insertMeta(mark, openvdb::BoolMetadata(true));
    }
    const FloatGrid::Ptr chosen = selectDensity(shown, name);
    if (!(*chosen)[mark]) return chosen;
    const FloatGrid::Ptr solid = levelSetToSolid(*chosen);
    if (solid->empty())
        throw InvalidArgument("'" + file.path + "': the level set '" + chosen->getName() +
                              "' has no inside: no distance in it is negative");
    solid->removeMeta(mark);
    return solid;
}

}  // namespace raysweep
