#include "raysweep/volume/cycles_export.h"

#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/volume/voxel_check.h"

#include <openvdb/points/PointDataGrid.h>
#include <openvdb/tools/Morphology.h>

namespace raysweep {
namespace {

constexpr const char* kExportKey = "raysweep_export";

template <class GridType>
void extend(GridType& grid) {
    constexpr double kLeafVoxels = 512;
    requireMemory(double(grid.activeVoxelCount()) / kLeafVoxels, sizeof(typename GridType::ValueType));
    voxelizeTiles(grid);
    openvdb::tools::dilateActiveValues(grid.tree(), 1, openvdb::tools::NN_FACE_EDGE_VERTEX,
                                       openvdb::tools::IGNORE_TILES);
}

bool isMovable(const openvdb::GridBase& grid) {
    return grid.transform().isLinear() && !grid.isType<openvdb::points::PointDataGrid>();
}

}  // namespace

std::vector<std::string> moveForCycles(VdbFile& file) {
    requireOriginal(file);
    std::vector<std::string> left;
    for (const openvdb::GridBase::Ptr& grid : file.grids) {
        if (!isMovable(*grid)) {
            left.push_back(grid->getName());
            continue;
        }
        const openvdb::math::Transform::Ptr moved = grid->transform().copy();
        moved->preTranslate(openvdb::Vec3d(-0.5));
        grid->setTransform(moved);
    }
    file.metadata.insertMeta(kExportKey, openvdb::StringMetadata("blender: grids moved by minus half a voxel"));
    return left;
}

void extendForCycles(openvdb::GridBase& grid) {
    if (grid.isType<openvdb::FloatGrid>()) extend(static_cast<openvdb::FloatGrid&>(grid));
    if (grid.isType<openvdb::Vec3SGrid>()) extend(static_cast<openvdb::Vec3SGrid&>(grid));
}

void requireOriginal(const VdbFile& file) {
    if (file.metadata[kExportKey])
        throw InvalidArgument("'" + file.path + "'", Remedy::useOriginal,
                              ": its grids are moved by half a voxel, for Blender; use the file it was made from");
}

}  // namespace raysweep
