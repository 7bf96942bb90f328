/// raysweep photo: a volume from photographs.
#include "photo_report.h"
#include "plot.h"

#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/image/image_io.h"
#include "raysweep/volume/color_volume.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/voxel_check.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <set>

namespace fs = std::filesystem;

namespace raysweep::apps {
namespace {

const std::map<std::string, PhotoMethod> kMethods = {
    {"consistent", PhotoMethod::consistent}, {"fit", PhotoMethod::fit}, {"paper", PhotoMethod::paper}};

void requireOutputs(const PhotoArguments& a) {
    requireWritable(a.output);
    if (!a.plot.empty()) requirePlot(a.plot);
    if (!a.compareViews.empty()) makeOutputFolder(a.compareViews);
}

PhotographSets readSets(const PhotoArguments& a) {
    PhotographSetOptions options;
    options.poses = a.poses;
    options.photographs = a.photographs;
    options.chooseMatting = !a.mattingGiven;
    options.holdOut = a.holdOut;
    options.test = a.test;
    options.bounds = a.box;
    TerminalProgress progress(a.common);
    return readPhotographSets(a.input, options, progress.callback());
}

ColorVolume readReference(const std::string& path) {
    const VdbFile file = readVdb(path);
    ColorVolume volume;
    volume.density = selectDensity(file);
    volume.color = colorGrid(file);
    if (!volume.color)
        throw InvalidArgument("'" + path + "' has no colours: a vec3s grid 'Cd' is needed in a reference");
    checkFinite(*volume.density, path);
    return volume;
}

/// The method, if none was asked for.
void chooseMethod(PhotoArguments& a, const PhotographSets& sets) {
    if (!a.method.empty()) return;
    const bool lit = a.findLight || a.shading.diffuse > 0 || a.shading.ambient != 1;
    const bool parallel = sets.used.views.front().camera.projection == Camera::Projection::Orthographic;
    const bool asksFit = a.refinePoses || a.sh > 0 || a.smooth;
    a.method = (parallel || lit) && !asksFit ? "consistent" : "fit";
    detail(a.common, "method " + a.method);
}

PhotoOptions optionsFor(const PhotoArguments& a, const PhotographSets& sets) {
    PhotoOptions options;
    options.method = kMethods.at(a.method);
    options.box = a.box || a.reference.empty() ? sets.bounds : std::nullopt;
    options.resolution = a.size;
    if (a.iterations) options.iterations = *a.iterations;
    if (a.relaxation) options.relaxation = *a.relaxation;
    if (a.smooth) {
        options.fit.smoothness = *a.smooth;
        options.fit.adaptSmoothness = false;
    }
    options.fit.refinePoses = a.refinePoses;
    options.fit.sh = a.sh;
    options.light = {a.shading, !a.lampStands};
    options.light.shading.light = a.lightInWorld.value_or(sets.used.views.front().camera.forward);
    options.findLight = a.findLight;
    options.seed = a.common.seed;
    options.historyEvery = a.historyEvery;
    if (!a.reference.empty()) options.reference = readReference(a.reference);
    return options;
}

/// Pictures of one name in several folders get numbers.
class ComparisonFiles {
  public:
    explicit ComparisonFiles(std::string folder) : folder_(std::move(folder)) {}

    std::string next(const std::string& picture, const std::string& set) {
        const std::string stem = fs::path(picture).stem().string() + (set.empty() ? "" : "_" + set);
        std::string name = stem;
        for (int number = 2; !taken_.insert(name).second; ++number) name = stem + "-" + std::to_string(number);
        return (fs::path(folder_) / (name + ".png")).string();
    }

  private:
    std::string folder_;
    std::set<std::string> taken_;
};

Judgement judgeAll(const PhotoArguments& a, const PhotographSets& sets, const ColorVolume& volume,
                   const Shading& shading) {
    PhotoQualityOptions options;
    options.backdrop = float(a.backdrop);
    options.shading = shading;
    if (!a.lampStands) options.lampBeside = sets.used.views.front().camera;
    ComparisonFiles files(a.compareViews);
    TerminalProgress progress(a.common);
    const auto judgeSet = [&](const PhotographSet& set, const char* name) {
        const auto see = [&](std::size_t n, const Image& render) {
            writeImage(files.next(set.views[n].name, name),
                       comparisonPicture(set.views[n].matte, render, options.backdrop));
        };
        return judge(volume, set.views, options, a.compareViews.empty() ? SeeRender() : see, progress.callback());
    };
    Judgement judgement;
    judgement.used = judgeSet(sets.used, "");
    if (!judgement.used.complete) return judgement;
    judgement.standingOut = viewsStandingOut(judgement.used.views);
    judgement.heldOut = judgeSet(sets.heldOut, "held_out");
    if (judgement.heldOut.complete) judgement.test = judgeSet(sets.test, "test");
    if (!volume.directional.constant || !judgement.test.complete) return judgement;
    options.colors = [&](const PhotoCamera& camera) { return colorSeenFrom(volume.directional, camera); };
    judgement.directional = judge(volume, sets.heldOut.views, options, {}, progress.callback());
    return judgement;
}

void setMeta(openvdb::GridBase& grid, const PhotoArguments& a, const PhotographSets& sets) {
    grid.insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
    grid.insertMeta("raysweep_photo_method", openvdb::StringMetadata(a.method));
    grid.insertMeta("raysweep_photo_input", openvdb::StringMetadata(fs::path(a.input).filename().string()));
    grid.insertMeta("raysweep_photo_views", openvdb::Int64Metadata(std::int64_t(sets.used.views.size())));
}

void write(const PhotoArguments& a, const PhotographSets& sets, const ColorVolume& volume) {
    std::size_t clamped = 0;
    const openvdb::GridPtrVec grids = gridsOf(volume);
    openvdb::GridCPtrVec written;
    for (const openvdb::GridBase::Ptr& grid : grids) {
        requireFiniteResult(*grid, kTooLarge);
        setMeta(*grid, a, sets);
        grid->setSaveFloatAsHalf(a.half);
        if (const auto scalars = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) clamped += clampForHalf(*scalars);
        if (const auto colors = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid)) clamped += clampForHalf(*colors);
        written.push_back(grid);
    }
    if (clamped > 0) warning(a.common, "values beyond half floats were set to 65504");
    writeVdb(a.output, written);
}

/// " 'a' (1 dB), 'b' (2 dB), ..."
std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t kNamed = 5;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kNamed); ++i) text += (i == 0 ? " " : ", ") + names[i];
    return text + (names.size() > kNamed ? ", ..." : "");
}

/// "3 views are met much worse than the others; are their poses right? 'a' (20 dB), ...".
std::string describeStandingOut(const Judgement& judgement) {
    const std::size_t count = judgement.standingOut.size();
    std::string text = count == 1 ? "one view is met much worse than the others; is its pose right?"
                                  : std::to_string(count) +
                                        " views are met much worse than the others; are their poses "
                                        "right?";
    std::vector<std::string> names;
    for (const std::size_t n : judgement.standingOut) {
        const ViewQuality& view = judgement.used.views[n];
        names.push_back("'" + view.name + "' (" + brief(view.psnr, 3) + " dB)");
    }
    return text + listed(names);
}

/// Which cameras were moved, those that were the farthest first.
std::string describeMoved(const PhotoOutcome& outcome) {
    constexpr double kSeen = 0.01;  // pixels: below, it is the rounding of what all have in common
    const std::vector<RefinedPose>& poses = outcome.result.poses;
    std::vector<std::size_t> moved;
    for (std::size_t n = 0; n < poses.size(); ++n)
        if (poses[n].motion > kSeen) moved.push_back(n);
    if (moved.empty()) return "no pose had to be moved";
    std::stable_sort(moved.begin(), moved.end(),
                     [&](std::size_t a, std::size_t b) { return poses[a].motion > poses[b].motion; });
    std::vector<std::string> names;
    for (const std::size_t n : moved)
        names.push_back("'" + outcome.sets.used.views[n].name + "' (" + brief(poses[n].motion, 2) + " pixels)");
    return (moved.size() == 1 ? "one pose was moved:" : std::to_string(moved.size()) + " poses were moved:") +
           listed(names);
}

void commentLight(const PhotoArguments& a, PhotoOutcome& outcome) {
    constexpr double kSure = 0.4;  // of confidence: below it the opposite light has been found instead
    if (!outcome.result.light) return;
    const PhotoLight& light = *outcome.result.light;
    detail(a.common, "light: " + brief(100 * light.shading.diffuse, 2) + " % of it diffuse, confidence " +
                         brief(light.confidence, 2));
    if (light.confidence >= kSure) return;
    outcome.warnings.push_back("the pictures hardly tell where the light comes from (confidence " +
                               brief(light.confidence, 2) +
                               "): it is nearly all ambient, or the opposite light suits them as well");
    warning(a.common, outcome.warnings.back());
}

void comment(const PhotoArguments& a, PhotoOutcome& outcome) {
    const Judgement& judgement = outcome.judgement;
    commentLight(a, outcome);
    if (!judgement.standingOut.empty()) {
        outcome.warnings.push_back(describeStandingOut(judgement));
        warning(a.common, outcome.warnings.back());
    }
    if (a.refinePoses) message(a.common, describeMoved(outcome));
    if (outcome.result.termination == PhotoTermination::overfitted)
        message(a.common, "the views carry " + std::to_string(outcome.result.resolution) +
                              " voxels along the longest edge: finer ones made left-out pixels worse");
    if (outcome.result.termination == PhotoTermination::noRoom) {
        outcome.warnings.push_back("there is no memory for more than " + std::to_string(outcome.result.resolution) +
                                   " voxels along the longest edge");
        warning(a.common, outcome.warnings.back());
    }
    if (outcome.result.density->empty()) {
        outcome.warnings.push_back("the volume is empty");
        warning(a.common, outcome.warnings.back());
    }
    const auto tell = [&](const PhotoQuality& quality, const char* what) {
        if (!quality.views.empty())
            detail(a.common, what + brief(quality.psnr, 4) + " dB, SSIM " + brief(quality.ssim, 3) + " (" +
                                 std::to_string(quality.views.size()) + " views)");
    };
    tell(judgement.used, "views that were used: ");
    tell(judgement.heldOut, "views held out: ");
    tell(judgement.test, "test views: ");
    tell(judgement.directional, "views held out, in colours of their directions: ");
}

bool isInterrupted(const PhotoReconstruction& result) {
    return result.termination == PhotoTermination::interrupted;
}

bool isComplete(const Judgement& judgement) {
    return judgement.used.complete && judgement.heldOut.complete && judgement.test.complete &&
           judgement.directional.complete;
}

/// Reads, reconstructs and writes the volume. @return false if it was stopped before there was anything to write
bool make(PhotoArguments& a, PhotoOutcome& outcome, Shading& shading) {
    outcome.sets = readSets(a);
    outcome.warnings = outcome.sets.warnings;
    for (const std::string& unlikely : outcome.warnings) warning(a.common, unlikely);
    if (!outcome.sets.complete || TerminalProgress::interrupted()) return false;
    chooseMethod(a, outcome.sets);
    const PhotoOptions options = optionsFor(a, outcome.sets);
    shading = options.light.shading;
    TerminalProgress progress(a.common);
    outcome.result = reconstructPhotographs(outcome.sets.used.views, options, progress.callback());
    for (std::size_t n = 0; n < outcome.result.poses.size(); ++n)
        outcome.sets.used.views[n].camera = outcome.result.poses[n].camera;
    if (outcome.result.light) shading = outcome.result.light->shading;
    return !(isInterrupted(outcome.result) && outcome.result.density->empty());
}

/// Looks what photographs see; without memory for that, the volume is still there. @return false if it was stopped
bool addConfidence(const PhotoArguments& a, PhotoOutcome& outcome, ColorVolume& volume) {
    const Timer timer;
    TerminalProgress progress(a.common);
    try {
        outcome.confidence = photoConfidence(*volume.density, outcome.sets.used.views, {}, progress.callback());
    } catch (const std::bad_alloc&) {
        outcome.warnings.push_back("there is no memory to look what was seen: no confidence is written");
        warning(a.common, outcome.warnings.back());
        return true;
    }
    volume.confidence = outcome.confidence.confidence;
    volume.views = outcome.confidence.views;
    outcome.confidenceSeconds = timer.seconds();
    return volume.confidence != nullptr;
}

int run(PhotoArguments& a) {
    const ThreadLimit limit = start(a.common);
    requireOutputs(a);
    resetPeak();
    const std::size_t before = residentBytes();
    const Timer timer;
    PhotoOutcome outcome;
    Shading shading;
    if (!make(a, outcome, shading)) {
        message(a.common, "stopped; nothing was written");
        return kInterrupted;
    }
    const PhotoReconstruction& result = outcome.result;
    ColorVolume volume{result.density, result.color};
    volume.directional = result.directional;
    bool stopped = isInterrupted(result);
    if (a.confidence && !stopped) stopped = !addConfidence(a, outcome, volume);
    write(a, outcome.sets, volume);
    if (stopped) message(a.common, "stopped; '" + a.output + "' holds the volume so far");
    if (!stopped) outcome.judgement = judgeAll(a, outcome.sets, volume, shading);
    comment(a, outcome);
    outcome.seconds = timer.seconds();
    const std::size_t peak = peakResidentBytes();
    outcome.peakBytes = peak > before ? peak - before : 0;
    writeReport(a.common, describe(a, outcome));
    if (!a.plot.empty()) plotHistory(a.plot, result);
    return stopped || !isComplete(outcome.judgement) ? kInterrupted : kDone;
}

}  // namespace

void addPhoto(CLI::App& app, int& exitCode) {
    CLI::App* command = app.add_subcommand("photo", "Reconstruct a volume from photographs");
    const auto arguments = std::make_shared<PhotoArguments>();
    addPhotoOptions(*command, *arguments);
    command->callback([arguments, command, &exitCode] {
        completeOptions(*arguments, *command);
        exitCode = run(*arguments);
    });
}

}  // namespace raysweep::apps
