/// raysweep-cube4 render: a picture of a lit volume by the machine.
#include "machine_options.h"
#include "subcommands.h"

#include "hints.h"

#include "cube4/rendering.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"
#include "raysweep/image/image_io.h"
#include "raysweep/volume/grid_select.h"

#include <nlohmann/json.hpp>

#include <memory>

namespace raysweep::apps {
namespace {

struct Arguments {
    MachineArguments machine;
    std::string input, output, grid, size = "512,512", direction, up = "0,0,1";
    double extinction = 1, exposure = 0;
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
    app.add_option("--view", a.direction, "Direction of sight")->required()->type_name("X,Y,Z");
    app.add_option("--up", a.up, "Direction that points up in the picture")->capture_default_str()->type_name("X,Y,Z");
    app.add_option("--size", a.size, "Width and height, pixels")->capture_default_str()->type_name("W,H");
    app.option_defaults()->group("Picture");
    app.add_option("--density", a.grid, "Grid that is seen (default: extinction, else density)")->type_name("NAME");
    app.add_option("--extinction", a.extinction, "Extinction per unit density, 1/world unit")->capture_default_str();
    app.add_option("--background", a.setup.background, "Radiance behind the volume")->capture_default_str();
    app.add_flag("--lambert", a.setup.lambert, "Shade by gradients: the paper's cosine factor");
    app.add_option("--depth", a.setup.depth, "Where samples lie between one slice and the next, [0,1)")
        ->capture_default_str();
    app.add_option("--exposure", a.exposure, "For .png: colours times 2^EV")->capture_default_str()->type_name("EV");
    addMachineOptions(app, a.machine);
}

const openvdb::GridBase* gridCalled(const VdbFile& file, const std::string& name) {
    for (const openvdb::GridBase::Ptr& grid : file.grids)
        if (grid->getName() == name) return grid.get();
    return nullptr;
}

cube4::LitVolume litVolume(const Arguments& a) {
    const VdbFile file = readVdb(a.input);
    const bool own = a.grid.empty() && gridCalled(file, "extinction");
    const openvdb::FloatGrid::Ptr density = selectDensity(file, own ? "extinction" : a.grid);
    const openvdb::GridBase::ConstPtr lit = selectGrid(file, "radiosity");
    if (lit->transform() != density->transform())
        throw InvalidArgument(a.input + ": density and radiosity have different voxels; the machine has one memory");
    cube4::LitVolume volume;
    volume.box = cube4::boxAround(*density, a.machine.maxVoxels);
    const openvdb::Vec3d origin =
        density->transform().indexToWorld(openvdb::Coord(volume.box.low.x, volume.box.low.y, volume.box.low.z));
    volume.origin = Vec3(origin.x(), origin.y(), origin.z());
    volume.extinction = cube4::denseField(*density, volume.box);
    for (float& value : volume.extinction) value = float(double(value) * (own ? 1 : a.extinction));
    const int channels = lit->isType<openvdb::FloatGrid>() ? 1 : 3;
    for (int c = 0; c < channels; ++c) volume.radiosity.push_back(cube4::denseField(*lit, volume.box, c));
    return volume;
}

int run(Arguments& a) {
    const ThreadLimit limit = start(a.machine.common);
    initializeGrids();
    requireWritable(a.output);
    const cube4::LitVolume volume = litVolume(a);
    constexpr int kMostPixels = 1 << 14;
    const std::vector<int> size = parseWhole(a.size, "--size", 2, {1, kMostPixels}, "512,512");
    const cube4::ParallelView view =
        cube4::viewOf(volume, parseVec3(a.direction, "--view"), parseVec3(a.up, "--up"), size[0], size[1]);
    a.setup.pipelines = a.machine.pipelines;
    a.setup.format = parseFormat(a.machine);
    cube4::Trace trace;
    trace.most = a.machine.trace;
    a.setup.trace = a.machine.trace > 0 ? &trace : nullptr;
    const Timer timer;
    const cube4::Rendering rendering = cube4::renderView(volume, view, a.setup);
    const MachineUse use{rendering.counters,       rendering.passes,      rendering.voxels,
                         rendering.bytesPerModule, rendering.bufferBytes, timer.seconds()};
    showTrace(a.machine, trace);
    printUse("rendering", a.machine, use);
    const bool png = imageFormat(a.output) == ImageFormat::Png;
    writeImage(a.output, png ? toneMap(rendering.image, a.exposure) : rendering.image);
    nlohmann::ordered_json report = describeMachine(a.machine, use);
    report["step"] = rendering.step;
    // The same view for raysweep render: --eye, --target, --up, --ortho.
    const Vec3 middle = view.origin + view.column * (0.5 * (view.width - 1)) + view.row * (0.5 * (view.height - 1));
    const Vec3 eye = middle - view.direction * (view.column.length() * (view.width + view.height));
    report["target"] = {middle.x, middle.y, middle.z};
    report["eye"] = {eye.x, eye.y, eye.z};
    report["ortho"] = view.column.length() * view.width;
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
        requireFileOutput(arguments->output);
        if (imageFormat(arguments->output) == ImageFormat::Unknown) usageError("--output", "must end in .exr or .png");
        requireValid(*command, [&] { arguments->setup.validate(); });
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
