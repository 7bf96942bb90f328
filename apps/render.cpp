/// raysweep render: a picture, or a turntable of pictures, of a lit volume.
#include "cli.h"
#include "hints.h"
#include "render_source.h"

#include "raysweep/core/output_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/image/image_io.h"
#include "raysweep/render/render.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <memory>
#include <optional>

namespace raysweep::apps {
namespace {

/// What the user typed; empty text: not given.
struct Arguments {
    CommonOptions common;
    RenderOptions options;
    RenderSource source;
    std::vector<std::string> outputs;
    std::string size = "512,512", eye, target, up, background = "0";
    double fov = Camera().fov;
    std::optional<double> orthoWidth;
    int turntable = 0;
    double exposure = 0;
};

void addOptions(CLI::App& app, Arguments& a) {
    app.add_option("input", a.source.input,
                   "Lit volume, a .vdb written by raysweep light, or one with colours (density and Cd)")
        ->required()
        ->type_name("LIT.vdb");
    app.add_option("-o,--output", a.outputs, "Picture to write, .exr (linear) or .png (sRGB); repeatable")
        ->required()
        ->allow_extra_args(false)
        ->type_name("FILE");
    app.option_defaults()->group("Camera");
    app.add_option("--size", a.size, "Width and height, pixels")->capture_default_str()->type_name("W,H");
    app.add_option("--eye", a.eye, "Where the camera stands, world units (default: so that all is seen)")
        ->type_name("X,Y,Z");
    app.add_option("--target", a.target, "Point in the middle of the picture (default: the volume's middle)")
        ->type_name("X,Y,Z");
    app.add_option("--up", a.up, "Direction that points up in the picture (default: 0,0,1)")->type_name("X,Y,Z");
    auto* fov =
        app.add_option("--fov", a.fov, "Vertical field of view, degrees")->type_name("DEG")->capture_default_str();
    app.add_option("--ortho", a.orthoWidth, "Parallel projection instead of --fov; width of the picture, world units")
        ->type_name("WIDTH")
        ->excludes(fov);
    app.option_defaults()->group("Picture");
    app.add_option(
           "--background", a.background,
           "Linear radiance behind the volume, one number or R,G,B; part of the picture's colour, not of its alpha")
        ->capture_default_str()
        ->type_name("R,G,B");
    addRenderSource(app, a.source);
    app.option_defaults()->group("Picture");
    app.add_option("--step", a.options.step,
                   "Distance between samples, voxels; where something shines by itself at most 0.25, and of that 0.125")
        ->capture_default_str();
    app.add_option("--samples", a.options.samples, "Rays per pixel along each side: 2 means 2 x 2")
        ->capture_default_str();
    app.add_flag("--lambert", a.options.lambert, "Multiply by the cosine between view and surface normal");
    app.add_option("--turntable", a.turntable, "Number of frames around the axis up; writes name_0001.png ...")
        ->check(CLI::Range(1, 9999).description(""))
        ->type_name("N");
    app.add_option("--exposure", a.exposure, "Brightness of .png pictures, stops: 1 is twice as bright")
        ->type_name("EV")
        ->capture_default_str();
    addCommonOptions(app, a.common);
    reads(app.get_option("input"));
    writes(app.get_option("--output"), [&a](const std::string& output) {
        std::vector<std::string> files;
        for (int frame = 1; frame <= a.turntable; ++frame) files.push_back(numberedName(output, frame));
        return a.turntable ? files : std::vector<std::string>{output};
    });
}

/// Fails now rather than after the rendering.
void requireOutputs(const Arguments& a) {
    for (const std::string& output : a.outputs) {
        requireFileOutput(output, "--output");
        if (imageFormat(output) == ImageFormat::Unknown)
            usageError("--output", "'" + output + "' must end in .exr or .png");
        requireWritable(a.turntable ? numberedName(output, 1) : output);
    }
}

/// Whole numbers W,H.
std::array<int, 2> parseSize(const std::string& text) {
    const std::vector<double> size = parseNumbers(text, "--size", 2, 2, "640,480");
    for (const double s : size)
        if (!(s >= 1 && s <= 32768 && s == int(s)))
            usageError("--size", "'" + text + "': two whole numbers from 1 to 32768 are needed");
    return {int(size[0]), int(size[1])};
}

/// The camera without its place.
Camera lensFrom(const Arguments& a) {
    Camera camera;
    camera.width = parseSize(a.size)[0];
    camera.height = parseSize(a.size)[1];
    camera.fov = a.fov;
    if (!a.up.empty()) camera.up = parseDirection(a.up, "--up");
    if (a.orthoWidth) {
        camera.projection = Camera::Projection::Orthographic;
        camera.orthoWidth = *a.orthoWidth;
    }
    return camera;
}

/// `lens` put where the user wants it; whatever is left open frames the volume.
Camera place(Camera lens, const Arguments& a, const RenderInput& input) {
    Box3 bounds = worldBounds(input);
    if (bounds.isEmpty()) bounds = Box3(Vec3(-1), Vec3(1));  // an empty volume shows the background
    const Camera whole = framed(lens, bounds);
    lens.target = a.target.empty() ? whole.target : parseVec3(a.target, "--target");
    lens.eye = a.eye.empty() ? lens.target + (whole.eye - whole.target) : parseVec3(a.eye, "--eye");
    lens.validate();
    return lens;
}

void writeFrame(const Arguments& a, const Image& image, int frame) {
    requireFinite(image.pixels, "the picture");
    for (const std::string& output : a.outputs) {
        const std::string path = a.turntable ? numberedName(output, frame + 1) : output;
        writeImage(path, imageFormat(path) == ImageFormat::Png ? toneMap(image, a.exposure) : image);
        detail(a.common, "wrote " + path);
    }
}

/// Sums over all pixels, per channel.
std::array<double, 4> channelSums(const Image& image) {
    std::array<double, 4> sums{};
    for (std::size_t i = 0; i < image.pixels.size(); ++i) sums[i % 4] += image.pixels[i];
    return sums;
}

nlohmann::ordered_json listOf(const Vec3& v) {
    return {v.x, v.y, v.z};
}

nlohmann::ordered_json describe(const Arguments& a, const RenderInput& input, const Camera& camera) {
    nlohmann::ordered_json json = {{"input", a.source.input},
                                   {"outputs", a.outputs},
                                   {"width", camera.width},
                                   {"height", camera.height},
                                   {"density", input.density->getName()},
                                   {"extinction", input.extinctionScale},
                                   {"emission", bool(input.emission)},
                                   {"step", a.options.step},
                                   {"samples", a.options.samples},
                                   {"lambert", a.options.lambert},
                                   {"eye", listOf(camera.eye)},
                                   {"target", listOf(camera.target)},
                                   {"up", listOf(camera.up)}};
    const bool parallel = camera.projection == Camera::Projection::Orthographic;
    json[parallel ? "ortho" : "fov"] = parallel ? camera.orthoWidth : camera.fov;
    return json;
}

/// Everything that can be said to be wrong before a file is read.
Camera requireArguments(Arguments& a, const CLI::App& command) {
    a.options.background = parseColor(a.background, "--background");
    const Camera lens = lensFrom(a);
    requireValid(command, [&] {
        a.options.validate();
        framed(lens, Box3(Vec3(-1), Vec3(1)));
    });
    requireRenderSource(a.source, command);
    if (!std::isfinite(a.exposure)) usageError("--exposure", "must be finite");
    requireOutputs(a);
    return lens;
}

int run(Arguments& a, const CLI::App& command) {
    const ThreadLimit limit = start(a.common);
    const Camera lens = requireArguments(a, command);
    const RenderInput input = renderInput(a.source);
    const Camera camera = place(lens, a, input);

    const int frames = a.turntable ? a.turntable : 1;
    const Timer timer;
    const RenderVolume volume(input);
    double seconds = timer.seconds();
    std::array<double, 4> mean{};
    int done = 0;
    bool complete = true;
    TerminalProgress terminal(a.common);
    const ProgressCallback progress = terminal.callback();
    const auto frameProgress = [&](const std::string& stage, double fraction) {
        return report(progress, stage, (done + fraction) / frames);
    };
    for (; done < frames && complete; ++done) {
        const RenderResult result = render(volume, orbit(camera, 2 * kPi * done / frames), a.options, frameProgress);
        writeFrame(a, result.image, done);
        commitRunOutputs();  // frames can be looked at as they come
        const std::array<double, 4> sums = channelSums(result.image);
        for (int c = 0; c < 4; ++c) mean[c] += sums[c] / (double(camera.width) * camera.height);
        seconds += result.seconds;
        complete = result.complete;
    }
    for (double& m : mean) m /= done;
    if (complete && mean[3] == 0)
        warning(a.common, "nothing of the volume is in the picture: it is out of view, empty or transparent");
    nlohmann::ordered_json json = describe(a, input, camera);
    json["seconds"] = seconds;
    json["mean"] = mean;
    json["frames"] = done;
    json["complete"] = complete;
    writeReport(a.common, json);
    return complete ? kDone : kInterrupted;
}

}  // namespace

void addRender(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("render", "Make a picture of a lit volume");
    const auto arguments = std::make_shared<Arguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] { exitCode = run(*arguments, *command); });
}

}  // namespace raysweep::apps
