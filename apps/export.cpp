/// raysweep export: a copy of a volume that Blender shows in its place.
#include "cli.h"

#include "raysweep/core/output_file.h"
#include "raysweep/volume/vdb_io.h"

#include <openvdb/points/PointDataGrid.h>

#include <nlohmann/json.hpp>

#include <memory>

namespace raysweep::apps {
namespace {

struct ExportOptions {
    CommonOptions common;
    std::string input, output;
};

/// Cycles takes voxel (i,j,k) for the cube from (i,j,k) to (i+1,j+1,k+1), OpenVDB for the one around (i,j,k): half a
/// voxel apart, which is another distance for grids of another resolution. Nothing in Blender can move one grid of an
/// object and not the others, so it is done here. Points are not shown by Cycles as voxels.
bool moveForCycles(openvdb::GridBase& grid) {
    if (!grid.transform().isLinear() || grid.isType<openvdb::points::PointDataGrid>()) return false;
    const openvdb::math::Transform::Ptr moved = grid.transform().copy();
    moved->preTranslate(openvdb::Vec3d(-0.5));
    grid.setTransform(moved);
    return true;
}

void runExport(const ExportOptions& options) {
    requireFileOutput(options.output);
    const ThreadLimit limit = start(options.common);
    requireWritable(options.output);
    const Timer timer;
    VdbFile file = readVdb(options.input);
    requireOriginal(file);
    openvdb::GridCPtrVec grids;
    for (const openvdb::GridBase::Ptr& grid : file.grids) {
        if (!moveForCycles(*grid))
            warning(options.common, "grid '" + grid->getName() +
                                        "' is left where it is: it holds points or has a perspective transform");
        grids.push_back(grid);
    }
    file.metadata.insertMeta(kExportKey, openvdb::StringMetadata("blender: grids moved by minus half a voxel"));
    writeVdb(options.output, grids, file.metadata);
    writeReport(options.common, {{"grids", grids.size()}, {"seconds", timer.seconds()}});
}

}  // namespace

void addExport(CLI::App& app, int&) {
    CLI::App* command = app.add_subcommand("export", "Make a copy of a lit volume that Blender shows in its place");
    const auto options = std::make_shared<ExportOptions>();
    command->add_option("input", options->input, "Lit volume, a .vdb written by raysweep light")
        ->required()
        ->type_name("LIT.vdb");
    command
        ->add_option("-o,--output", options->output,
                     "The same grids, each moved back by the half voxel by which Blender's Cycles misplaces it")
        ->required()
        ->type_name("OUT.vdb");
    addCommonOptions(*command, options->common);
    command->callback([options] { runExport(*options); });
}

}  // namespace raysweep::apps
