#include "raysweep/volume/medium.h"

#include "raysweep/volume/active_values.h"
#include "raysweep/volume/voxel_check.h"

namespace raysweep {

openvdb::FloatGrid::Ptr extinctionGrid(const Medium& medium) {
    const openvdb::FloatGrid::Ptr grid = medium.density->deepCopy();
    voxelizeTiles(*grid);
    const auto scale = float(medium.extinctionScale);
    if (scale != 1) forEachActive(*grid, [&](float& value, const openvdb::CoordBBox&) { value *= scale; });
    grid->setName("extinction");
    return grid;
}

}  // namespace raysweep
