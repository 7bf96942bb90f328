/// raysweep shoot: photographs of a volume by a virtual rig, and where they were taken from.
#include "cli.h"
#include "hints.h"
#include "render_source.h"

#include "raysweep/camera/poses.h"
#include "raysweep/core/error.h"
#include "raysweep/core/output_folder.h"
#include "raysweep/core/text_file.h"
#include "raysweep/image/image_io.h"
#include "raysweep/render/rig.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <regex>

namespace fs = std::filesystem;

namespace raysweep::apps {
namespace {

const std::string kTransforms = "transforms.json", kRigFile = "rig.json";

/// What stands behind the volume; without a colour its alpha is kept.
struct Backdrop {
    std::string name;
    std::optional<Color> color;
};

/// What the user typed; empty text: not given.
struct Arguments {
    CommonOptions common;
    RenderSource source;
    RigOptions cameras;
    Rig rig;
    std::string output, orbit = "ring", size = "256,256", up, ortho, light, backdrop = "alpha", format = "png";
    std::optional<double> ambient;
    std::vector<Backdrop> backdrops;
};

void addOptions(CLI::App& app, Arguments& a) {
    app.add_option("input", a.source.input, "Volume with colours (density and Cd), or lit, as raysweep render shows it")
        ->required()
        ->type_name("VOL.vdb");
    app.add_option("-o,--output", a.output, "Folder for pictures, transforms.json and rig.json; replaced as a whole")
        ->required()
        ->type_name("DIR");
    app.option_defaults()->group("Cameras");
    app.add_option("--views", a.cameras.views, "Number of pictures")->capture_default_str();
    app.add_option("--orbit", a.orbit, "Where cameras stand: a ring about the axis up, or evenly on a sphere")
        ->check(CLI::IsMember({"ring", "sphere"}).description(""))
        ->type_name("ring|sphere")
        ->capture_default_str();
    app.add_option("--arc", a.cameras.arc, "Ring: degrees from the first view to where one after the last would be")
        ->type_name("DEG")
        ->capture_default_str();
    app.add_option("--up", a.up, "Axis of the ring, which points up in pictures (default: 0,0,1)")->type_name("X,Y,Z");
    auto* fov = app.add_option("--fov", a.cameras.fov, "Vertical field of view, degrees; all of the volume is seen")
                    ->type_name("DEG")
                    ->capture_default_str();
    app.add_option("--ortho", a.ortho,
                   "Parallel projection instead of --fov; width of a picture, world units, or auto: all is seen")
        ->type_name("WIDTH|auto")
        ->excludes(fov);
    app.option_defaults()->group("Light");
    app.add_option("--ambient", a.ambient, "Part of colours that is seen whatever the light (default: 1 - diffuse)");
    app.add_option("--diffuse", a.rig.shading.diffuse, "Part of colours that is seen by Lambert's law")
        ->capture_default_str();
    app.add_option(
           "--light", a.light,
           "Direction in which light travels in the first view; the lamp is fixed to the camera (default: along "
           "the view)")
        ->type_name("X,Y,Z");
    app.option_defaults()->group("Pictures");
    app.add_option("--backdrop", a.backdrop,
                   "Behind the volume: alpha (nothing, pictures have alpha), white, black, a colour, or several of the "
                   "names, each in pictures of its own")
        ->type_name("alpha|white|black|white,black|R,G,B")
        ->capture_default_str();
    app.add_option("--size", a.size, "Width and height, pixels")->capture_default_str()->type_name("W,H");
    app.add_option("--format", a.format, "exr: linear, floats; png: sRGB, 8 bits")
        ->check(CLI::IsMember({"exr", "png"}).description(""))
        ->type_name("exr|png")
        ->capture_default_str();
    app.add_option("--step", a.rig.picture.step, "Distance between samples, voxels")->capture_default_str();
    app.add_option("--samples", a.rig.picture.samples, "Rays per pixel along each side: 2 means 2 x 2")
        ->capture_default_str();
    addRenderSource(app, a.source);
    reads(app.get_option("input"));
    fills(app.get_option("--output"), /*replaced=*/true);
    app.option_defaults()->group("Options");
    addCommonOptions(app, a.common);
}

std::vector<Backdrop> parseBackdrops(const std::string& text) {
    const char* const option = "--backdrop";
    if (text.empty() || !std::isalpha(static_cast<unsigned char>(text[0])))
        return {{"color", parseColor(text, option)}};
    std::vector<Backdrop> backdrops;
    for (const std::string& name : split(text, ',')) {
        if (name != "alpha" && name != "white" && name != "black")
            usageError(option, "'" + name + "' is none of alpha, white and black");
        for (const Backdrop& other : backdrops)
            if (other.name == name) usageError(option, "'" + name + "' is given twice");
        backdrops.push_back({name, name == "alpha" ? std::nullopt : std::optional(grey(name == "white"))});
    }
    return backdrops;
}

/// Everything that can be said to be wrong before a file is read.
void completeOptions(Arguments& a, const CLI::App& command) {
    a.cameras.orbit = a.orbit == "ring" ? RigOrbit::ring : RigOrbit::sphere;
    if (a.orbit == "sphere" && command.count("--arc") > 0) usageError("--arc", "is for --orbit ring only");
    if (!a.up.empty()) a.cameras.up = parseDirection(a.up, "--up");
    if (!a.ortho.empty()) {
        a.cameras.projection = Camera::Projection::Orthographic;
        a.cameras.orthoWidth = a.ortho == "auto" ? 0 : parseNumber(a.ortho, "--ortho", "2.5 or auto");
        if (a.ortho != "auto" && !(a.cameras.orthoWidth > 0)) usageError("--ortho", "the width must be positive");
    }
    const std::vector<int> size = parseWhole(a.size, "--size", 2, {1, 32768}, "640,480");
    a.cameras.width = size[0], a.cameras.height = size[1];
    a.rig.shading.ambient = a.ambient.value_or(std::max(0.0, 1 - a.rig.shading.diffuse));
    if (!a.light.empty()) a.rig.shading.light = parseDirection(a.light, "--light");
    if (!a.light.empty() && !(a.rig.shading.diffuse > 0)) usageError("--light", "needs --diffuse as well");
    a.backdrops = parseBackdrops(a.backdrop);
    requireValid(command, [&] {
        a.cameras.validate();
        a.rig.shading.validate();
        a.rig.picture.validate();
    });
    requireRenderSource(a.source, command);
}

std::string numbered(const Arguments& a, std::size_t view, const Backdrop& backdrop) {
    const std::string suffix = a.backdrops.size() > 1 ? "_" + backdrop.name : "";
    const std::string name = numberedName("view." + a.format, int(view) + 1);
    return fs::path(name).stem().string() + suffix + "." + a.format;
}

/// Files that this subcommand writes.
bool isOurs(const std::string& name) {
    static const std::regex kPicture("view_[0-9]{4,}(_(alpha|white|black))?\\.(png|exr)");
    return name == kTransforms || name == kRigFile || std::regex_match(name, kPicture);
}

/// Writes the pictures of a view, and says where it was taken from.
Pose writeView(const Arguments& a, const std::string& folder, std::size_t view, const Image& picture) {
    Pose pose;
    pose.camera = photoCamera(a.rig.cameras[view]);
    const PhotoCamera first = photoCamera(a.rig.cameras.front());
    pose.camera.focalX = first.focalX, pose.camera.focalY = first.focalY;  // one lens, whatever the axes' rounding
    requireFinite(picture.pixels, "a picture");
    for (const Backdrop& backdrop : a.backdrops) {
        const std::string path = (fs::path(folder) / numbered(a, view, backdrop)).string();
        writeImage(path, backdrop.color ? overBackdrop(picture, *backdrop.color) : picture);
        if (pose.image.empty() || backdrop.name == "alpha") pose.image = path;
        if (backdrop.name == "white") pose.onWhite = path;
        if (backdrop.name == "black") pose.onBlack = path;
    }
    return pose;
}

nlohmann::ordered_json listOf(const Vec3& v) {
    return {v.x, v.y, v.z};
}

/// How it was lit, and what was in front of what.
nlohmann::ordered_json describeRig(const Arguments& a) {
    const CameraFrame first = cameraFrame(a.rig.cameras.front());
    const Vec3 light = a.rig.shading.light.normalized();
    nlohmann::ordered_json backdrops = nlohmann::ordered_json::object();
    for (const Backdrop& backdrop : a.backdrops)
        backdrops[backdrop.name] = backdrop.color
                                       ? nlohmann::ordered_json{backdrop.color->x, backdrop.color->y, backdrop.color->z}
                                       : nlohmann::ordered_json(nullptr);
    nlohmann::ordered_json json = {{"format", "raysweep-rig"},
                                   {"version", 1},
                                   {"raysweep_version", RAYSWEEP_VERSION},
                                   {"volume", fs::path(a.source.input).filename().string()},
                                   {"orbit", a.orbit},
                                   {"up", listOf(a.cameras.up)},
                                   {"ambient", a.rig.shading.ambient},
                                   {"diffuse", a.rig.shading.diffuse},
                                   {"backdrops", backdrops},
                                   {"step", a.rig.picture.step},
                                   {"samples", a.rig.picture.samples}};
    if (a.orbit == "ring") json["arc"] = a.cameras.arc;
    if (a.rig.shading.diffuse > 0)  // right, down and forward: of every camera the same
        json["light"] = {light.dot(first.right.normalized()), -light.dot(first.up.normalized()),
                         light.dot(first.forward)};
    return json;
}

void writeRig(const std::string& folder, const Arguments& a, const Poses& poses) {
    writeTransforms((fs::path(folder) / kTransforms).string(), poses);
    writeText((fs::path(folder) / kRigFile).string(), describeRig(a).dump(2) + "\n");
}

/// Cameras for the volume; says if it will be cut off.
void placeCameras(Arguments& a, const RenderInput& volume) {
    const Box3 bounds = worldBounds(volume);
    if (bounds.isEmpty())
        throw InvalidArgument("'" + a.source.input + "': the grid '" + volume.density->getName() +
                              "' has no active voxels, so there is nothing to photograph");
    a.rig.cameras = rigCameras(a.cameras, bounds);
    if (a.light.empty()) a.rig.shading.light = cameraFrame(a.rig.cameras.front()).forward;
    if (!(a.cameras.orthoWidth > 0)) return;
    RigOptions whole = a.cameras;
    whole.orthoWidth = 0;
    const double needed = rigCameras(whole, bounds).front().orthoWidth / kRigMargin;
    if (a.cameras.orthoWidth < needed * (1 - 1e-9))
        warning(a.common, "pictures are " + brief(a.cameras.orthoWidth, 3) +
                              " wide, but all of the volume's box needs " + brief(needed, 4) + ": it may be cut off");
}

int run(Arguments& a) {
    const ThreadLimit limit = start(a.common);
    OutputFolder folder(a.output, isOurs);
    const RenderInput volume = renderInput(a.source);
    placeCameras(a, volume);
    Poses poses;
    poses.bounds = worldBounds(volume);
    double alpha = 0;
    const Timer timer;
    TerminalProgress terminal(a.common);
    const std::size_t done = shoot(
        volume, a.rig,
        [&](std::size_t view, const Image& picture) {
            poses.views.push_back(writeView(a, folder.temporary(), view, picture));
            for (std::size_t i = 3; i < picture.pixels.size(); i += 4) alpha += picture.pixels[i];
        },
        terminal.callback());
    const bool complete = done == a.rig.cameras.size();
    if (done > 0) {
        writeRig(folder.temporary(), a, poses);
        folder.commit();
    }
    const double seconds = timer.seconds(), pixels = double(a.cameras.width) * a.cameras.height;
    if (!complete)
        message(a.common, done == 0 ? "stopped; nothing was written"
                                    : "stopped; '" + a.output + "' holds the first " + std::to_string(done) + " of " +
                                          std::to_string(a.rig.cameras.size()) + " views");
    detail(a.common, std::to_string(done) + " views written to '" + a.output + "'");
    nlohmann::ordered_json json = describeRig(a);
    json["views"] = done;
    json["width"] = a.cameras.width;
    json["height"] = a.cameras.height;
    json["seconds"] = seconds;
    json["seconds_per_view"] = seconds / double(std::max<std::size_t>(done, 1));
    json["coverage"] = alpha / (pixels * double(std::max<std::size_t>(done, 1)));
    json["complete"] = complete;
    writeReport(a.common, json);
    return complete ? kDone : kInterrupted;
}

}  // namespace

void addShoot(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("shoot", "Photograph a volume from all around, for raysweep photo");
    const auto arguments = std::make_shared<Arguments>();
    addOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        requireFileOutput(arguments->output);
        completeOptions(*arguments, *command);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
