/// raysweep export: a volume for other programs. A copy that Blender shows in its place, or a dense file.
#include "dense_options.h"
#include "volume_output.h"

#include "raysweep/core/output_file.h"
#include "raysweep/formats/dense_files.h"
#include "raysweep/volume/cycles_export.h"

#include <nlohmann/json.hpp>

#include <memory>

namespace raysweep::apps {
namespace {

struct ExportOptions {
    CommonOptions common;
    std::string input, output;
    DenseArguments dense;
};

/// Everything that can be said to be wrong before a file is read.
void requireOptions(const ExportOptions& options, const CLI::App& command) {
    requireVolumeOutput(options.output);
    denseChoice(options.dense);
    if (!isVdb(options.output)) return;
    for (const char* name : {"--grid", "--channel", "--dense-box"})
        if (command.count(name) > 0) usageError(name, "is for other files; a .vdb keeps all that there is");
}

void exportForBlender(const ExportOptions& options) {
    requireWritable(options.output);
    const Timer timer;
    VdbFile file = readVdb(options.input);
    for (const std::string& name : moveForCycles(file))
        warning(options.common,
                "grid '" + name + "' is left where it is: it holds points or has a perspective transform");
    writeVdb(options.output, openvdb::GridCPtrVec(file.grids.begin(), file.grids.end()), file.metadata);
    writeReport(options.common, {{"grids", file.grids.size()}, {"seconds", timer.seconds()}});
}

void exportDense(const ExportOptions& options) {
    requireDenseOutput(options.output);
    const Timer timer;
    DenseSource source = denseSource(options.input, options.dense);
    writeDense(options.output, source);
    const DenseLayout& layout = source.layout();
    const auto list = [](const auto& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
    writeReport(options.common, {{"grid", source.name()},
                                 {"corner", list(source.corner())},
                                 {"dims", list(layout.dims)},
                                 {"origin", list(layout.origin)},
                                 {"spacing", list(layout.spacing())},
                                 {"seconds", timer.seconds()}});
}

void run(const ExportOptions& options, const CLI::App& command) {
    requireOptions(options, command);
    const ThreadLimit limit = start(options.common);
    isVdb(options.output) ? exportForBlender(options) : exportDense(options);
}

}  // namespace

void addExport(CLI::App& app, int&) {
    CLI::App* command = app.add_subcommand("export", "Write a volume for Blender, or a dense one for other programs");
    const auto options = std::make_shared<ExportOptions>();
    reads(command->add_option("input", options->input, "Volume"))->required()->type_name("VOL.vdb");
    auto* const output = command->add_option(
        "-o,--output", options->output,
        ".vdb: the same grids, each moved back by the half voxel by which Blender's Cycles misplaces it; .mha, .nrrd, "
        ".nii, .nii.gz, or a folder for .tif slices (a name without an ending, or one with a slash at its end; "
        "replaced "
        "as a whole): the voxels of one grid, 32 bit floats");
    output->required()->type_name("OUT");
    writesOrFills(output, [](const std::string& value) { return denseFormat(value) == DenseFormat::tiffFolder; });
    addDenseOptions(*command, options->dense);
    addCommonOptions(*command, options->common);
    command->callback([options, command] { run(*options, *command); });
}

}  // namespace raysweep::apps
