/// raysweep-cube4 render: a picture of a lit volume by the machine.
#include "machine_options.h"
#include "subcommands.h"

#include "hints.h"

#include "cube4/rendering.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"
#include "raysweep/image/image_io.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <memory>
#include <optional>

namespace raysweep::apps {
namespace {

struct Arguments {
    MachineArguments machine;
    std::string input, output, grid, size = "512,512", direction, eye, up = "0,0,1";
    std::optional<double> extinction;
    double exposure = 0, fov = 40;
    cube4::RenderSetup setup;
};

void addOptions(CLI::App& app, Arguments& a) {
    app.add_option("input", a.input, "Lit volume: density, or extinction, and radiosity")
        ->required()
        ->type_name("LIT.vdb");
    app.add_option("-o,--output", a.output, "Picture to write, .exr (linear) or .png (sRGB)")
        ->required()
        ->type_name("FILE");
    app.option_defaults()->group("View");
    app.add_option("--view", a.direction, "Direction of sight: parallel, unless there is an eye")->type_name("X,Y,Z");
    app.add_option("--eye", a.eye,
                   "In perspective: where rays come from, outside the volume or in it; it looks along --view "
                   "(default: to the volume's middle)")
        ->type_name("X,Y,Z");
    app.add_option("--fov", a.fov, "With --eye: angle between top and bottom edge, degrees, (0,180)")
        ->capture_default_str()
        ->type_name("DEG");
    app.add_option("--up", a.up, "Direction that points up in the picture")->capture_default_str()->type_name("X,Y,Z");
    app.add_option("--size", a.size, "Width and height, pixels")->capture_default_str()->type_name("W,H");
    app.option_defaults()->group("Picture");
    app.add_option("--density", a.grid, "Grid that is seen (default: extinction, else density)")->type_name("NAME");
    app.add_option("--extinction", a.extinction,
                   "Extinction per unit density, 1/world unit (default: as it was lit with, else 1)");
    app.add_option("--background", a.setup.background, "Radiance behind the volume")->capture_default_str();
    app.add_flag("--lambert", a.setup.lambert, "Shade by gradients: the paper's cosine factor");
    app.add_option("--depth", a.setup.depth, "Where samples lie between one slice and the next, [0,1)")
        ->capture_default_str();
    app.add_option("--exposure", a.exposure, "For .png: colours times 2^EV")->capture_default_str()->type_name("EV");
    addMachineOptions(app, a.machine);
    addPerspectiveOptions(app, a.machine);
}

void requireView(const Arguments& a) {
    if (a.extinction) requireFactor(*a.extinction, "--extinction");
    if (!std::isfinite(a.exposure)) usageError("--exposure", "must be finite");
    if (a.machine.noOverlap) usageError("--no-overlap", "has no meaning here: nothing is written back");
    if (a.eye.empty() && a.direction.empty()) usageError("--view", "say where to look, or with --eye from where");
    if (!(a.fov > 0 && a.fov < 180)) usageError("--fov", "must be in (0,180)");
    if (a.eye.empty()) return;
    if (a.setup.lambert) usageError("--lambert", "goes with parallel rays, not with --eye");
    if (a.setup.depth > 0) usageError("--depth", "is 0 with --eye: samples are in slices");
}

const openvdb::GridBase* gridCalled(const VdbFile& file, const std::string& name) {
    for (const openvdb::GridBase::Ptr& grid : file.grids)
        if (grid->getName() == name) return grid.get();
    return nullptr;
}

/// Extinction per unit density, as lit files say.
double litExtinction(const openvdb::GridBase& radiosity) {
    const auto scale = radiosity.getMetadata<openvdb::DoubleMetadata>("raysweep_extinction");
    return scale ? scale->value() : 1;
}

/// What the machine has no memory for.
void warnOfFire(const Arguments& a, const VdbFile& file) {
    for (const openvdb::GridBase::Ptr& grid : file.grids)
        if (grid->getName() == "emission" && (*grid)["raysweep_density"])
            warning(a.machine.common,
                    "'" + a.input +
                        "': what its grid 'emission' gives off by itself is not shown; the light that "
                        "is scattered of it is");
}

cube4::LitVolume litVolume(const Arguments& a) {
    const VdbFile file = readVdb(a.input);
    warnOfFire(a, file);
    const openvdb::GridBase::ConstPtr lit = selectGrid(file, "radiosity");
    const bool own = a.grid.empty() && gridCalled(file, "extinction");
    const openvdb::FloatGrid::Ptr density = selectDensity(file, own ? "extinction" : a.grid);
    checkVoxels(*density, density->getName());
    withTypedGrid(*lit, [](const auto& grid) { checkVoxels(grid, "radiosity"); });
    if (lit->transform() != density->transform())
        throw InvalidArgument(a.input + ": density and radiosity have different voxels; the machine has one memory");
    cube4::LitVolume volume;
    volume.box = cube4::boxAround(*density, a.machine.maxVoxels);
    // Radiosity reaches a voxel further, so that what is interpolated at an edge is not mixed with nothing.
    volume.box.low -= Index3(1);
    volume.box.high += Index3(1);
    cube4::requireAtMost(volume.box, a.machine.maxVoxels);
    const double scale = own ? 1 : a.extinction.value_or(litExtinction(*lit));
    const openvdb::Vec3d origin =
        density->transform().indexToWorld(openvdb::Coord(volume.box.low.x, volume.box.low.y, volume.box.low.z));
    volume.origin = Vec3(origin.x(), origin.y(), origin.z());
    volume.extinction = cube4::denseField(*density, volume.box);
    for (float& value : volume.extinction) value = float(double(value) * scale);
    const int channels = lit->isType<openvdb::FloatGrid>() ? 1 : 3;
    for (int c = 0; c < channels; ++c) volume.radiosity.push_back(cube4::denseField(*lit, volume.box, c));
    return volume;
}

nlohmann::ordered_json toJson(const Vec3& v) {
    return {v.x, v.y, v.z};
}

/// @param same takes the options of raysweep render that give the same view
cube4::Rendering rendered(const Arguments& a, const cube4::LitVolume& volume, nlohmann::ordered_json& same) {
    constexpr int kMostPixels = 1 << 14;
    const std::vector<int> size = parseWhole(a.size, "--size", 2, {1, kMostPixels}, "512,512");
    const Vec3 up = parseDirection(a.up, "--up");
    if (a.eye.empty()) {
        const cube4::ParallelView view =
            cube4::viewOf(volume, parseDirection(a.direction, "--view"), up, size[0], size[1]);
        const Vec3 middle = view.origin + view.column * (0.5 * (view.width - 1)) + view.row * (0.5 * (view.height - 1));
        same["target"] = toJson(middle);
        same["eye"] = toJson(middle - view.direction * (view.column.length() * (view.width + view.height)));
        same["ortho"] = view.column.length() * view.width;
        return cube4::renderView(volume, view, a.setup);
    }
    const Vec3 eye = parseVec3(a.eye, "--eye");
    const Vec3 middle = volume.origin + Vec3(volume.box.size() - Index3(1)) * 0.5 * volume.box.worldFromIndex;
    const Vec3 direction = a.direction.empty() ? middle - eye : parseDirection(a.direction, "--view");
    same["target"] = toJson(eye + direction);
    same["eye"] = toJson(eye);
    same["fov"] = a.fov;
    return cube4::renderView(volume, cube4::viewFrom(eye, direction, up, a.fov, {size[0], size[1]}), a.setup);
}

int run(Arguments& a) {
    const ThreadLimit limit = start(a.machine.common);
    initializeGrids();
    requireWritable(a.output);
    const cube4::LitVolume volume = litVolume(a);
    a.setup.pipelines = a.machine.pipelines;
    a.setup.format = parseFormat(a.machine);
    a.setup.sampling = a.machine.sampling;
    cube4::Trace trace;
    trace.most = a.machine.trace;
    a.setup.trace = a.machine.trace > 0 ? &trace : nullptr;
    const Timer timer;
    nlohmann::ordered_json same;
    const cube4::Rendering rendering = rendered(a, volume, same);
    const MachineUse use{rendering.counters,       rendering.passes,      rendering.voxels,
                         rendering.bytesPerModule, rendering.bufferBytes, timer.seconds()};
    showTrace(a.machine, trace);
    printUse("rendering", a.machine, use);
    requireFinite(rendering.image.pixels, "the picture");
    const bool png = imageFormat(a.output) == ImageFormat::Png;
    writeImage(a.output, png ? toneMap(rendering.image, a.exposure) : rendering.image);
    nlohmann::ordered_json report = describeMachine(a.machine, use);
    report["step"] = rendering.step;
    report.update(same);
    writeReport(a.machine.common, report);
    return kDone;
}

}  // namespace

void addCube4Render(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("render", "A picture of a lit volume by the machine");
    const auto arguments = std::make_shared<Arguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        requireMachine(*command, arguments->machine);
        requireView(*arguments);
        requireFileOutput(arguments->output);
        if (imageFormat(arguments->output) == ImageFormat::Unknown) usageError("--output", "must end in .exr or .png");
        requireValid(*command, [&] { arguments->setup.validate(); });
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
