/// raysweep generate: volumes made from nothing.
#include "cli.h"

#include "raysweep/core/output_file.h"
#include "raysweep/volume/phantom.h"
#include "raysweep/volume/vdb_io.h"

#include <nlohmann/json.hpp>

#include <map>
#include <memory>

namespace raysweep::apps {
namespace {

struct GenerateOptions {
    CommonOptions common;
    PhantomOptions phantom;
    std::string kind, output, dims;
    bool half = false;
};

using Maker = openvdb::FloatGrid::Ptr (*)(const PhantomOptions&);
const std::map<std::string, Maker> kMakers = {{"box", makeBox}, {"cloud", makeCloud}, {"sphere", makeSphere}};

openvdb::Coord parseDims(const std::string& text) {
    const std::vector<int> dims = parseWhole(text, "--dims", 3, 1, 4096, "64,32,16");
    return openvdb::Coord(dims[0], dims[1], dims[2]);
}

void runGenerate(GenerateOptions options) {
    requireFileOutput(options.output);
    if (!options.dims.empty() && options.kind != "box") usageError("--dims", "is for the box only");
    if (!options.dims.empty()) options.phantom.dims = parseDims(options.dims);
    if (options.kind == "sphere" && options.phantom.soft > 0.5 * options.phantom.size)
        usageError("--soft", "must be at most half of --size");
    options.phantom.seed = options.common.seed;
    requireWritable(options.output);

    const ThreadLimit limit = start(options.common);
    const Timer timer;
    const openvdb::FloatGrid::Ptr grid = kMakers.at(options.kind)(options.phantom);
    grid->setSaveFloatAsHalf(options.half);
    grid->insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
    grid->insertMeta("raysweep_generate",
                     openvdb::StringMetadata(options.kind + " --size " + std::to_string(options.phantom.size) +
                                             " --seed " + std::to_string(options.phantom.seed)));
    writeVdb(options.output, {grid});
    detail(options.common, options.kind + " of " + std::to_string(grid->activeVoxelCount()) + " voxels written to '" +
                               options.output + "'");
    writeReport(options.common, {{"voxels_active", grid->activeVoxelCount()}, {"seconds", timer.seconds()}});
}

}  // namespace

void addGenerate(CLI::App& app, int&) {
    CLI::App* command = app.add_subcommand("generate", "Make a volume: cloud, sphere or box");
    const auto options = std::make_shared<GenerateOptions>();
    PhantomOptions& phantom = options->phantom;
    command->add_option("kind", options->kind, "What to make")
        ->required()
        ->check(CLI::IsMember(kMakers).description(""))
        ->type_name("cloud|sphere|box");
    command->add_option("-o,--output", options->output, "The .vdb file to write")->required()->type_name("OUT.vdb");
    command->add_option("--size", phantom.size, "Longest edge, voxels")
        ->check(CLI::Range(2, 4096).description(""))
        ->capture_default_str();
    command
        ->add_option("--voxel-size", phantom.voxelSize,
                     "Edge of a voxel, world units (default: longest edge is 2 units)")
        ->check(CLI::PositiveNumber.description(""));
    command->add_option("--density", phantom.density, "Largest density")
        ->check(CLI::PositiveNumber.description(""))
        ->capture_default_str();
    command->add_option("--soft", phantom.soft, "Sphere: width of its soft edge, voxels; 0: none")
        ->check(CLI::NonNegativeNumber.description(""))
        ->capture_default_str();
    command->add_option("--dims", options->dims, "Box: voxels along each axis instead of --size")->type_name("X,Y,Z");
    command->add_flag("--half", options->half, "Save as half floats");
    addCommonOptions(*command, options->common);
    command->callback([options] { runGenerate(*options); });
}

}  // namespace raysweep::apps
