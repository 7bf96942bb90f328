#include "photo_options.h"
#include "hints.h"

#include "raysweep/core/file_name.h"

#include <algorithm>
#include <map>
#include <vector>

namespace raysweep::apps {
namespace {

using Matting = MattingOptions::Matting;

const std::map<std::string, CameraAxes> kAxes = {{"opengl", CameraAxes::openGl}, {"opencv", CameraAxes::openCv}};
const std::map<std::string, Matting> kMattings = {{"alpha", Matting::alpha}, {"white-black", Matting::whiteBlack},
                                                  {"black", Matting::black}, {"white", Matting::white},
                                                  {"known", Matting::known}, {"masks", Matting::masks}};

void addInputOptions(CLI::App& app, PhotoArguments& a) {
    app.add_option("input", a.input,
                   "Poses: transforms.json, the folder of a COLMAP model (text or binary), a list of K, R, t "
                   "(Middlebury's _par.txt) or of projection matrices")
        ->required()
        ->type_name("INPUT");
    app.add_option("-o,--output", a.output, "The .vdb file to write: grids density (1/world unit), opacity and Cd")
        ->required()
        ->type_name("VOL.vdb");
    app.option_defaults()->group("Photographs");
    app.add_option("--images", a.poses.imageFolder, "Folder with the pictures (default: where INPUT says)")
        ->type_name("DIR");
    app.add_option("--axes", a.axes, "How cameras' axes lie: y up and z back, or y down and z ahead (default: INPUT's)")
        ->check(CLI::IsMember(kAxes).description(""))
        ->type_name("opengl|opencv");
    app.add_option("--reduction", a.photographs.reduction, "Make pictures smaller by this factor")
        ->type_name("N")
        ->capture_default_str();
    app.add_option("--hold-out", a.holdOut, "Keep every K-th view from the reconstruction, to judge it by")
        ->type_name("K");
    app.add_option("--test", a.test, "More views that only judge: their poses, as INPUT")->type_name("FILE.json");
}

void addMattingOptions(CLI::App& app, PhotoArguments& a) {
    MattingOptions& options = a.photographs.matting;
    app.option_defaults()->group("Matting");
    app.add_option("--matting", a.matting,
                   "How the object is told from its backdrop: the pictures' alpha; pairs before white and black; one "
                   "picture before black, white or a known linear colour; masks, of a folder or those that INPUT names "
                   "(default: alpha, pairs or masks if every view has them)")
        ->type_name("alpha|white-black|black|white|known:R,G,B|masks[:DIR]");
    app.add_option("--threshold", options.threshold,
                   "black, white: display value up to which a pixel is backdrop; from twice that on it is object")
        ->capture_default_str();
    app.add_option("--nearest", options.nearest, "known: distance from the backdrop's colour up to which alpha is 0")
        ->capture_default_str();
    app.add_option("--farthest", options.farthest, "known: distance from which alpha is 1")->capture_default_str();
    app.add_option("--largest-hole", options.largestHole,
                   "black, white, known: gaps in the object up to this part of the picture are filled")
        ->capture_default_str();
    app.add_flag("--straight-alpha", options.straightAlpha, "alpha: colours are not yet multiplied by it (EXR)");
    app.add_option("--save-mattes", a.photographs.matteFolder, "Write a picture of each matte into this folder")
        ->type_name("DIR");
}

void addMethodOptions(CLI::App& app, PhotoArguments& a) {
    app.option_defaults()->group("Method");
    app.add_option("--method", a.method,
                   "fit: least squares by the exact derivative; consistent: corrections of optical depth; paper: "
                   "corrections of opacity (default: fit; consistent for parallel projection)")
        ->check(CLI::IsMember({"fit", "consistent", "paper"}).description(""))
        ->type_name("fit|consistent|paper");
    app.add_option("--iterations", a.iterations, "How often each pixel is used (default: by method)")->type_name("N");
    app.add_option("--relaxation", a.relaxation, "consistent, paper: part of each correction that is made");
    app.add_option("--smooth", a.smooth,
                   "fit: weight of the total variation that is kept small (default: from 0.003 on as pixels that are "
                   "left out want it)")
        ->type_name("W");
    app.add_flag("--refine-poses", a.refinePoses,
                 "fit: move cameras whose poses are wrong to where their pictures fit the others'");
    app.add_option(
           "--sh", a.sh,
           "fit: degree of the spherical harmonics that colours have of the direction they are seen from; 1 adds "
           "grids Cd_0, Cd_x, Cd_y, Cd_z, and Cd is a mean")
        ->check(CLI::IsMember({0, 1}).description(""))
        ->type_name("0|1")
        ->capture_default_str();
    app.add_option("--ambient", a.ambient,
                   "Part of colours that is seen whatever the light (default: 1 - diffuse), to take light out of Cd");
    app.add_option("--diffuse", a.shading.diffuse, "Part of colours that is seen by Lambert's law")
        ->capture_default_str();
    app.add_option("--light", a.light,
                   "Direction in which light travels in the first view (default: along the view); auto: found")
        ->type_name("X,Y,Z|auto");
    app.add_flag("--fixed-light", a.lampStands,
                 "The lamp stands still; else it goes along with the camera, as if the object turned on a table");
    app.add_option("--bounds", a.bounds, "Box of the volume, world units (default: what the photographs show)")
        ->type_name("X0,Y0,Z0,X1,Y1,Z1");
    app.add_option("--size", a.size,
                   "Voxels along the longest edge of the box, a multiple of 8 (default: 256 for fit, else 128)")
        ->type_name("N");
    app.add_flag("--confidence", a.confidence,
                 "Write how well photographs have seen each voxel, too: grids confidence and views");
    app.add_flag("--half", a.half, "Save as half floats");
}

void addCheckOptions(CLI::App& app, PhotoArguments& a) {
    app.option_defaults()->group("Pictures and checks");
    app.add_option("--reference", a.reference, "What it should be: adds RMS differences to report and plot")
        ->type_name("VOL.vdb");
    app.add_option("--backdrop", a.backdrop, "Grey, as displays encode it, on which PSNR and SSIM are taken")
        ->capture_default_str();
    app.add_option("--compare-views", a.compareViews,
                   "Write each view into this folder: photograph, render and their difference beside each other")
        ->type_name("DIR");
    app.add_option("--plot", a.plot, "How pictures are met against updates, .svg or .png")->type_name("FILE");
    app.add_option(
           "--history", a.historyEvery,
           "consistent, paper: updates from one point of the histories in report and plot to the next; 0: one a "
           "pass")
        ->type_name("N")
        ->capture_default_str();
}

/// @return false if `text` is none of the ways
bool parseMatting(const std::string& text, PhotographOptions& photographs) {
    const std::size_t colon = text.find(':');
    const auto found = kMattings.find(text.substr(0, colon));
    if (found == kMattings.end()) return false;
    MattingOptions& options = photographs.matting;
    options.matting = found->second;
    const std::string more = colon == std::string::npos ? "" : text.substr(colon + 1);
    if (options.matting == Matting::known) {
        if (more.empty()) usageError("--matting", "known needs the backdrop's colour; for example known:0,0.6,0.1");
        options.backdrop = parseColor(more, "--matting known:");
    } else if (options.matting == Matting::masks) {
        photographs.maskFolder = more;
    } else {
        return colon == std::string::npos;
    }
    return true;
}

/// Options that mean nothing to the way of matting would be ignored silently.
void requireFittingMatting(const PhotoArguments& a, const CLI::App& command) {
    const Matting matting = a.photographs.matting.matting;
    const auto only = [&](const char* option, std::initializer_list<Matting> ways, const char* names) {
        if (command.count(option) > 0 && (!a.mattingGiven || std::count(ways.begin(), ways.end(), matting) == 0))
            usageError(option, std::string("is for --matting ") + names);
    };
    only("--threshold", {Matting::black, Matting::white}, "black and white");
    only("--nearest", {Matting::known}, "known:R,G,B");
    only("--farthest", {Matting::known}, "known:R,G,B");
    only("--largest-hole", {Matting::black, Matting::white, Matting::known}, "black, white and known:R,G,B");
    only("--straight-alpha", {Matting::alpha}, "alpha");
}

void completePhotographs(PhotoArguments& a, const CLI::App& command) {
    if (!a.axes.empty()) a.poses.axes = kAxes.at(a.axes);
    a.mattingGiven = !a.matting.empty();
    if (a.mattingGiven && !parseMatting(a.matting, a.photographs))
        usageError("--matting",
                   "'" + a.matting + "' is none of alpha, white-black, black, white, known:R,G,B and masks[:DIR]");
    requireFittingMatting(a, command);
    if (command.count("--hold-out") > 0 && a.holdOut < 2)
        usageError("--hold-out", "must be at least 2: every K-th view is kept, and the others are used");
    requireValid(command, [&] { a.photographs.validate(); });
}

Box3 parseBounds(const std::string& text) {
    const std::vector<double> b = parseNumbers(text, "--bounds", 6, 6, "-1,-1,-1,1,1,1");
    for (int axis = 0; axis < 3; ++axis)
        if (!(b[std::size_t(axis)] < b[std::size_t(axis) + 3]))
            usageError("--bounds", "'" + text + "': X0,Y0,Z0 must be less than X1,Y1,Z1");
    return Box3(Vec3(b[0], b[1], b[2]), Vec3(b[3], b[4], b[5]));
}

void completeLight(PhotoArguments& a, const CLI::App& command) {
    a.shading.ambient = a.ambient.value_or(std::max(0.0, 1 - a.shading.diffuse));
    requireValid(command, [&] { a.shading.validate(); });
    if (a.light.empty()) return;
    a.findLight = a.light == "auto";
    if (a.findLight && a.lampStands) usageError("--fixed-light", "light that stands still cannot be found");
    if (!a.findLight) {
        a.lightInWorld = parseDirection(a.light, "--light");
        if (!(a.shading.diffuse > 0)) usageError("--light", "needs --diffuse as well");
    }
}

/// Options that mean nothing to the method would be ignored silently.
void requireFittingMethod(const PhotoArguments& a) {
    const char* const lit = a.light == "auto"        ? "--light"
                            : a.shading.diffuse > 0  ? "--diffuse"
                            : a.shading.ambient != 1 ? "--ambient"
                                                     : nullptr;
    const char* const corrected = lit                  ? lit
                                  : a.relaxation       ? "--relaxation"
                                  : a.historyEvery > 0 ? "--history"
                                                       : nullptr;
    if (a.method == "fit" && corrected) usageError(corrected, "is for --method consistent and paper");
    const char* const fitted = a.refinePoses ? "--refine-poses" : a.sh > 0 ? "--sh" : a.smooth ? "--smooth" : nullptr;
    if (((!a.method.empty() && a.method != "fit") || lit) && fitted) usageError(fitted, "is for --method fit");
    if (a.refinePoses && a.sh > 0) usageError("--refine-poses", "does not go with --sh 1");
}

void addFileRoles(CLI::App& app) {
    for (const char* name : {"input", "--images", "--test", "--reference"}) reads(app.get_option(name));
    reads(app.get_option("--matting"), [](const std::string& text) -> std::vector<std::string> {
        const std::string masks = "masks:";
        if (text.rfind(masks, 0) != 0) return {};
        return {text.substr(masks.size())};
    });
    for (const char* name : {"--output", "--plot"}) writes(app.get_option(name));
    for (const char* name : {"--save-mattes", "--compare-views"}) fills(app.get_option(name));
}

}  // namespace

void addPhotoOptions(CLI::App& app, PhotoArguments& a) {
    addInputOptions(app, a);
    addMattingOptions(app, a);
    addMethodOptions(app, a);
    addCheckOptions(app, a);
    addFileRoles(app);
    app.option_defaults()->group("Options");
    addCommonOptions(app, a.common);
}

void completeOptions(PhotoArguments& a, const CLI::App& command) {
    requireFileOutput(a.output);
    if (lowerExtension(a.output) != ".vdb") usageError("--output", "'" + a.output + "' must end in .vdb");
    completePhotographs(a, command);
    if (!a.bounds.empty()) a.box = parseBounds(a.bounds);
    if (a.size != 0 && (a.size < 16 || a.size > 1024 || a.size % 8 != 0))
        usageError("--size", "must be a multiple of 8, from 16 to 1024");
    if (a.smooth) requireFactor(*a.smooth, "--smooth");
    if (a.iterations && *a.iterations < 1) usageError("--iterations", "must be at least 1");
    if (a.historyEvery < 0) usageError("--history", "must be at least 0");
    completeLight(a, command);
    requireFittingMethod(a);
    if (!(a.backdrop >= 0 && a.backdrop <= 1)) usageError("--backdrop", "must be in [0,1]");
}

}  // namespace raysweep::apps
