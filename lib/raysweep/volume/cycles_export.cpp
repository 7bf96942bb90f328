#include "raysweep/volume/cycles_export.h"

#include "raysweep/core/error.h"

#include <openvdb/points/PointDataGrid.h>

namespace raysweep {
namespace {

constexpr const char* kExportKey = "raysweep_export";

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

void requireOriginal(const VdbFile& file) {
    if (file.metadata[kExportKey])
        throw InvalidArgument("'" + file.path + "'", Remedy::useOriginal,
                              ": its grids are moved by half a voxel, for Blender; use the file it was made from");
}

}  // namespace raysweep
