/// raysweep generate: volumes made from nothing.
#include "hints.h"
#include "scan_options.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"
#include "raysweep/phantoms/ct_phantoms.h"
#include "raysweep/phantoms/engine_room.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/phantoms/explosion.h"
#include "raysweep/phantoms/phantom.h"
#include "raysweep/phantoms/triangles.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/statistics.h"
#include "raysweep/volume/vdb_io.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <sstream>

namespace raysweep::apps {
namespace {

struct GenerateOptions {
    CommonOptions common;
    PhantomOptions phantom;
    EngineRoomOptions room;
    TrianglesOptions triangles;
    ScanArguments scan;
    std::string kind, output, dims, volume, volumeGrid, slices, projections;
    bool half = false;
};

const std::string kExplosion = "explosion", kRoom = "engine-room", kTriangles = "triangles";

using Maker = openvdb::FloatGrid::Ptr (*)(const PhantomOptions&);
const std::map<std::string, Maker> kMakers = {{"box", makeBox},
                                              {"box-with-holes", makeBoxWithHoles},
                                              {"cloud", makeCloud},
                                              {"shepp-logan", makeSheppLogan},
                                              {"sphere", makeSphere}};

openvdb::Coord parseDims(const std::string& text) {
    const std::vector<int> dims = parseWhole(text, "--dims", 3, {1, 4096}, "64,32,16");
    return openvdb::Coord(dims[0], dims[1], dims[2]);
}

/// What made the file, for its metadata.
std::string commandOf(const GenerateOptions& options) {
    std::ostringstream text;
    text << options.kind;
    if (options.kind != kRoom) {
        if (options.dims.empty())
            text << " --size " << options.phantom.size;
        else
            text << " --dims " << options.dims;
        text << " --seed " << options.common.seed;
        if (options.kind == kTriangles)
            text << " --count " << options.triangles.count << " --thickness " << options.triangles.thickness
                 << (options.triangles.binary ? " --binary" : "");
        return text.str();
    }
    if (options.room.size > 0) text << " --size " << options.room.size;
    if (!options.volume.empty()) text << " --volume " << std::filesystem::path(options.volume).filename().string();
    if (!options.slices.empty()) text << " --crop-slices " << options.slices;
    text << " --wall " << options.room.wall;
    if (options.room.openFront) text << " --open-front";
    if (options.room.coloured) text << " --coloured";
    return text.str();
}

void writeGrids(const GenerateOptions& options, const openvdb::GridPtrVec& grids) {
    for (const auto& grid : grids) {
        requireFiniteResult(*grid, kTooLarge);
        grid->setSaveFloatAsHalf(options.half);
        grid->insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
        grid->insertMeta("raysweep_generate", openvdb::StringMetadata(commandOf(options)));
    }
    writeVdb(options.output, openvdb::GridCPtrVec(grids.begin(), grids.end()));
    detail(options.common, options.kind + " of " + std::to_string(grids.front()->activeVoxelCount()) +
                               " voxels written to '" + options.output + "'");
}

/// The engine from a file, if there is one.
void readEngine(GenerateOptions& options) {
    if (options.volume.empty()) return;
    const openvdb::FloatGrid::Ptr engine = selectSolid(readVdb(options.volume), options.volumeGrid);
    const ValueRange range = valueRange(*engine);
    if (!range.max.empty() && range.max[0] > 1)
        warning(options.common, "the volume's densities go up to " + std::to_string(range.max[0]) +
                                    ", the walls have " + std::to_string(kWallDensity));
    options.room.engine = engine;
}

void runRoom(GenerateOptions options) {
    const Timer timer;
    readEngine(options);
    const EngineRoom room = makeEngineRoom(options.room);
    openvdb::GridPtrVec grids{room.density, room.emission};
    if (room.albedo) grids.push_back(room.albedo);
    writeGrids(options, grids);
    const auto list = [](const openvdb::Coord& c) { return nlohmann::ordered_json{c.x(), c.y(), c.z()}; };
    writeReport(options.common, {{"voxels_active", room.density->activeVoxelCount()},
                                 {"seconds", timer.seconds()},
                                 {"dims", list(room.dims)},
                                 {"engine_dims", list(room.engineDims)},
                                 {"light_area", room.lightArea},
                                 {"light_power", room.lightPower}});
}

/// RMS over all voxels of the cube: what a reconstruction that finds nothing is wrong by.
double rmsOverCube(const TrianglesOptions& options, double sumOfSquares) {
    return std::sqrt(sumOfSquares / std::pow(double(options.size), 3));
}

void runTriangles(const GenerateOptions& options) {
    const Timer timer;
    const ColorVolume volume = makeTriangles(options.triangles);
    writeGrids(options, gridsOf(volume));
    const ColorPower power = powerOf(volume);
    writeReport(options.common, {{"voxels_active", volume.density->activeVoxelCount()},
                                 {"seconds", timer.seconds()},
                                 {"rms_opacity", rmsOverCube(options.triangles, power.opacity)},
                                 {"rms_color", rmsOverCube(options.triangles, power.color)}});
}

void runExplosion(const GenerateOptions& options) {
    const Timer timer;
    const Explosion explosion = makeExplosion(options.phantom);
    writeGrids(options, {explosion.density, explosion.fire});
    writeReport(options.common, {{"voxels_active", explosion.density->activeVoxelCount()},
                                 {"voxels_fire", explosion.fire->activeVoxelCount()},
                                 {"seconds", timer.seconds()}});
}

/// Phantoms whose line integrals are known exactly.
bool hasShapes(const std::string& kind) {
    return kind == "shepp-logan" || kind == "box-with-holes";
}

void writeExactProjections(const GenerateOptions& options) {
    const ProjectionGeometry geometry = scanGeometry(options.scan.options);
    const auto shapes = options.kind == "shepp-logan" ? sheppLogan(options.phantom) : boxWithHoles(options.phantom);
    writeProjections(options.projections, exactProjections(shapes, geometry), pitchOf(geometry));
}

void runPhantom(const GenerateOptions& options) {
    const Timer timer;
    const openvdb::FloatGrid::Ptr grid = kMakers.at(options.kind)(options.phantom);
    writeGrids(options, {grid});
    if (!options.projections.empty()) writeExactProjections(options);
    writeReport(options.common, {{"voxels_active", grid->activeVoxelCount()}, {"seconds", timer.seconds()}});
}

/// Options that mean nothing for the kind that was asked for.
void requireFitting(const CLI::App& command, const std::string& kind) {
    const auto refuse = [&](std::initializer_list<const char*> names, const std::string& what) {
        for (const char* name : names)
            if (command.count(name) > 0) usageError(name, "is for " + what + " only");
    };
    if (kind != "box" && kind != "box-with-holes") refuse({"--dims"}, "box and box-with-holes");
    if (kind != kRoom)
        refuse({"--volume", "--volume-grid", "--crop-slices", "--wall", "--open-front", "--coloured"}, kRoom);
    if (kind == kRoom || kind == kTriangles)
        refuse({"--density", "--soft"}, "clouds, explosions, spheres, boxes and phantoms");
    if (kind != kTriangles) refuse({"--count", "--thickness", "--binary"}, kTriangles);
    if (kind != "sphere") refuse({"--soft"}, "the sphere");
    if (!hasShapes(kind)) refuse({"--projections"}, "shepp-logan and box-with-holes");
    if (command.count("--projections") == 0)
        for (const char* name : {"--geometry", "--parallel", "--cone", "--views", "--arc", "--first-angle",
                                 "--detector", "--pitch", "--center-row", "--orbit-center"})
            if (command.count(name) > 0) usageError(name, "needs --projections as well");
    if (kind == kRoom && command.count("--volume") > 0) refuse({"--voxel-size"}, "volumes made from nothing");
    if (kind == kRoom && command.count("--volume") == 0) refuse({"--volume-grid", "--crop-slices"}, "--volume");
}

/// Everything that can be said to be wrong before a volume is made.
void completeOptions(GenerateOptions& options, const CLI::App& command) {
    requireFileOutput(options.output);
    requireFitting(command, options.kind);
    if (!options.dims.empty()) options.phantom.dims = parseDims(options.dims);
    if (options.kind == "sphere" && options.phantom.soft > 0.5 * options.phantom.size)
        usageError("--soft", "must be at most half of --size");
    if (!options.projections.empty()) {
        requireProjectionOutput(options.projections, "--projections");
        completeScanOptions(options.scan);
        requireWhole(options.scan);
    }
    options.phantom.seed = options.common.seed;
    options.room.voxelSize = options.phantom.voxelSize;
    if (command.count("--size") > 0) options.room.size = options.phantom.size;
    if (!options.slices.empty()) {
        constexpr int kFar = 1 << 24;
        const std::vector<int> slices = parseWhole(options.slices, "--crop-slices", 2, {-kFar, kFar}, "0,109");
        options.room.slices = {slices[0], slices[1]};
    }
    if (options.kind == kRoom) requireValid(command, [&] { options.room.validate(); });
    options.triangles.size = options.phantom.size;
    options.triangles.voxelSize = options.phantom.voxelSize;
    options.triangles.seed = options.common.seed;
    if (options.kind == kTriangles) requireValid(command, [&] { options.triangles.validate(); });
}

void runGenerate(const GenerateOptions& options) {
    requireWritable(options.output);
    if (!options.projections.empty()) requireWritable(projectionFiles(options.projections, 1).front());
    const ThreadLimit limit = start(options.common);
    if (options.kind == kRoom)
        runRoom(options);
    else if (options.kind == kTriangles)
        runTriangles(options);
    else if (options.kind == kExplosion)
        runExplosion(options);
    else
        runPhantom(options);
}

void addRoomOptions(CLI::App& app, GenerateOptions& options) {
    app.option_defaults()->group("Engine room");
    app.add_option("--volume", options.volume,
                   "What stands in it, fog or level set (default: a block made from nothing)")
        ->type_name("ENGINE.vdb");
    app.add_option("--volume-grid", options.volumeGrid, "Its grid (default: density, else the only float grid)");
    app.add_option("--crop-slices", options.slices,
                   "Slices of the volume, along z, to take (default: those with something in them, and two of air)")
        ->type_name("K0,K1");
    app.add_option("--wall", options.room.wall, "Thickness of the walls, voxels")->capture_default_str();
    app.add_flag("--open-front", options.room.openFront, "Leave out the wall in front (low y)");
    app.add_flag("--coloured", options.room.coloured,
                 "Add a grid albedo: left wall red, right wall green, the rest grey");
    app.option_defaults()->group("Options");
}

void addTriangleOptions(CLI::App& app, GenerateOptions& options) {
    app.option_defaults()->group("Triangles");
    app.add_option("--count", options.triangles.count, "Number of triangles")->capture_default_str();
    app.add_option("--thickness", options.triangles.thickness, "Of a triangle's sheet, voxels")->capture_default_str();
    app.add_flag("--binary", options.triangles.binary,
                 "A voxel is full or empty, by its centre (default: filled in part where a triangle fills part of it)");
    app.option_defaults()->group("Options");
}

}  // namespace

void addGenerate(CLI::App& app, int&) {
    CLI::App* command = app.add_subcommand("generate",
                                           "Make a volume: cloud, explosion (smoke and fire), sphere, box, phantoms "
                                           "for tomography, coloured triangles, or "
                                           "the engine room");
    const auto options = std::make_shared<GenerateOptions>();
    PhantomOptions& phantom = options->phantom;
    command->add_option("kind", options->kind, "What to make")
        ->required()
        ->check(CLI::IsMember({"box", "box-with-holes", "cloud", kRoom.c_str(), kExplosion.c_str(), "shepp-logan",
                               "sphere", kTriangles.c_str()})
                    .description(""))
        ->type_name("cloud|explosion|sphere|box|shepp-logan|box-with-holes|triangles|engine-room");
    command->add_option("-o,--output", options->output, "The .vdb file to write")->required()->type_name("OUT.vdb");
    command
        ->add_option(
            "--size", phantom.size,
            "Longest edge, voxels; of the engine room with its walls 276, or what fits the volume, if not given")
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
    command->add_option("--dims", options->dims, "Boxes: voxels along each axis instead of --size")->type_name("X,Y,Z");
    command->add_flag("--half", options->half, "Save as half floats");
    command
        ->add_option("--projections", options->projections,
                     "shepp-logan, box-with-holes: also write exact line integrals, .mha or .exr pictures with numbers")
        ->type_name("PROJ.mha|.exr");
    addScanOptions(*command, options->scan);
    addTriangleOptions(*command, *options);
    addRoomOptions(*command, *options);
    addCommonOptions(*command, options->common);
    reads(command->get_option("--volume"));
    writes(command->get_option("--output"));
    writes(command->get_option("--projections"),
           [options](const std::string& output) { return projectionNames(output, options->scan); });
    command->callback([options, command] {
        completeOptions(*options, *command);
        runGenerate(*options);
    });
}

}  // namespace raysweep::apps
