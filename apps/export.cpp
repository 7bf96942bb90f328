/// raysweep export: a copy of a volume that Blender shows in its place.
#include "cli.h"

#include "raysweep/core/output_file.h"
#include "raysweep/volume/cycles_export.h"

#include <nlohmann/json.hpp>

#include <memory>

namespace raysweep::apps {
namespace {

struct ExportOptions {
    CommonOptions common;
    std::string input, output;
};

void runExport(const ExportOptions& options) {
    requireFileOutput(options.output);
    const ThreadLimit limit = start(options.common);
    requireWritable(options.output);
    const Timer timer;
    VdbFile file = readVdb(options.input);
    for (const std::string& name : moveForCycles(file))
        warning(options.common,
                "grid '" + name + "' is left where it is: it holds points or has a perspective transform");
    writeVdb(options.output, openvdb::GridCPtrVec(file.grids.begin(), file.grids.end()), file.metadata);
    writeReport(options.common, {{"grids", file.grids.size()}, {"seconds", timer.seconds()}});
}

}  // namespace

void addExport(CLI::App& app, int&) {
    CLI::App* command = app.add_subcommand("export", "Make a copy of a lit volume that Blender shows in its place");
    const auto options = std::make_shared<ExportOptions>();
    reads(command->add_option("input", options->input, "Lit volume, a .vdb written by raysweep light"))
        ->required()
        ->type_name("LIT.vdb");
    command
        ->add_option("-o,--output", options->output,
                     "The same grids, each moved back by the half voxel by which Blender's Cycles misplaces it")
        ->required()
        ->type_name("OUT.vdb");
    writes(command->get_option("--output"));
    addCommonOptions(*command, options->common);
    command->callback([options] { runExport(*options); });
}

}  // namespace raysweep::apps
