#include "raysweep/camera/photograph_sets.h"

#include "raysweep/camera/matting_choice.h"
#include "raysweep/camera/object_bounds.h"
#include "raysweep/camera/pose_check.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"

#include <ImathBoxAlgo.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <numeric>

namespace raysweep {
namespace {

constexpr double kMuchOfTheEdge = 0.02;  ///< of its pixels
constexpr double kMuchBeside = 0.1;      ///< the bounds: a stand may well be left out

std::string nameOf(const Pose& pose) {
    for (const std::string* file : {&pose.image, &pose.onWhite, &pose.onBlack})
        if (!file->empty()) return *file;
    return "";
}

/// Errors if (nearly) all cameras look away, warns if some do.
void checkLooking(const Poses& poses, const PhotographSetOptions& options, std::vector<std::string>& warnings) {
    const AxesFinding finding = checkAxes(poses, options.bounds);
    const std::size_t away = finding.lookingAway.size(), all = poses.views.size();
    if (away == 0) return;
    const std::string count =
        std::to_string(away) + " of " + std::to_string(all) + " cameras look away from the object";
    if (finding.better == CameraAxes::openGl)
        throw InvalidArgument(count + "; with OpenGL's axes (y up, z back) they look at it", Remedy::useOpenGlAxes);
    if (finding.better == CameraAxes::openCv)
        throw InvalidArgument(count + "; with OpenCV's axes (y down, z ahead) they look at it", Remedy::useOpenCvAxes);
    if (away == all)
        throw InvalidArgument(count +
                              ", whichever way their axes are taken: their poses, or the object's bounds, are wrong");
    warnings.push_back(count + ", '" + nameOf(poses.views[finding.lookingAway[0]]) + "' first");
}

MattingOptions::Matting mattingFor(const Poses& poses, const PhotographSetOptions& options) {
    if (!options.chooseMatting) return options.photographs.matting.matting;
    if (const auto evident = evidentMatting(poses)) return *evident;
    throw InvalidArgument(
        "not all pictures have alpha, nor are pairs before a white and a black backdrop, or masks, named for all: it "
        "must "
        "be said how the object is told from its backdrop",
        Remedy::chooseMatting);
}

struct Split {
    Poses used, heldOut;
};

Split split(Poses poses, int holdOut) {
    Split parts;
    parts.used = poses;
    parts.used.views.clear();
    for (std::size_t n = 0; n < poses.views.size(); ++n) {
        const bool held = holdOut > 0 && n % std::size_t(holdOut) == std::size_t(holdOut) - 1;
        (held ? parts.heldOut : parts.used).views.push_back(std::move(poses.views[n]));
    }
    if (holdOut > 0 && parts.heldOut.views.empty())
        throw InvalidArgument("every " + std::to_string(holdOut) + "th view is to be held out, but there are " +
                              std::to_string(parts.used.views.size()) + " only: hold out more often, or not at all");
    return parts;
}

/// Reads one set. @return false if it was stopped
bool readSet(const Poses& poses, const PhotographOptions& options, const ProgressCallback& progress, PhotographSet& set,
             std::vector<std::string>& warnings) {
    if (poses.views.empty()) return true;
    Photographs photographs = readPhotographs(poses, options, progress);
    set.views = std::move(photographs.views);
    set.mattes = std::move(photographs.reports);
    for (const PhotographWarning& warning : photographs.warnings)
        if (warning.kind != PhotographWarning::Kind::oneView) warnings.push_back(warning.message);
    return photographs.complete;
}

/// Part of the pixels along the picture's edge that are the object's.
double edgeCoverage(const Image& matte) {
    double covered = 0, count = 0;
    for (int y = 0; y < matte.height; ++y)
        for (int x = 0; x < matte.width; x += y == 0 || y == matte.height - 1 ? 1 : std::max(1, matte.width - 1))
            covered += matte.at(x, y)[3] > 0.5f, count += 1;
    return covered / count;
}

/// A backdrop that was not told from the object mostly reaches the edges of pictures.
void warnOfEdges(const PhotographSets& sets, std::vector<std::string>& warnings) {
    using Matting = MattingOptions::Matting;
    if (sets.matting != Matting::black && sets.matting != Matting::white && sets.matting != Matting::known) return;
    const std::vector<Photograph>& views = sets.used.views;
    const auto count = std::count_if(views.begin(), views.end(), [](const Photograph& photograph) {
        return edgeCoverage(photograph.matte) > kMuchOfTheEdge;
    });
    if (2 * std::size_t(count) > views.size())
        warnings.push_back(
            "in " + std::to_string(count) + " of " + std::to_string(views.size()) +
            " views what was taken for the object reaches the picture's edge: it may be backdrop; look at "
            "the mattes, and at the threshold");
}

/// Part of what the photographs show that no ray through the box could meet.
double partBeside(const Box3& box, const std::vector<Photograph>& views) {
    std::vector<double> beside(views.size()), all(views.size());
    parallelFor(views.size(), [&](std::size_t n) {
        const Photograph& view = views[n];
        for (int y = 0; y < view.matte.height; ++y)
            for (int x = 0; x < view.matte.width; ++x) {
                const double alpha = view.matte.at(x, y)[3];
                if (!(alpha > 0)) continue;
                const Ray ray = pixelRay(view.camera, x + 0.5, y + 0.5);
                all[n] += alpha;
                if (!Imath::intersects(box, Imath::Line3d(ray.origin, ray.origin + ray.direction))) beside[n] += alpha;
            }
    });
    const double sum = std::accumulate(all.begin(), all.end(), 0.0);
    return sum > 0 ? std::accumulate(beside.begin(), beside.end(), 0.0) / sum : 0;
}

/// Bounds that were asked for in other units, or of another object, cut off what the photographs show.
void warnOfBounds(const Box3& box, const PhotographSets& sets, std::vector<std::string>& warnings) {
    const double beside = partBeside(box, sets.used.views);
    if (beside > kMuchBeside)
        warnings.push_back(std::to_string(int(std::lround(100 * beside))) +
                           " % of what the photographs show lies beside the bounds that were given, and nothing can "
                           "be there: are they in the units and axes of the poses?");
}

Poses readTestPoses(const PhotographSetOptions& options, CameraAxes axes) {
    if (options.test.empty()) return {};
    PoseOptions same = options.poses;
    if (same.axes) same.axes = axes;
    return readPoses(options.test, same);
}

/// None for views that all run one way, and for such that see no common place.
std::optional<Box3> whereAllLook(const Poses& poses) {
    try {
        return estimatedBounds(poses);
    } catch (const InvalidArgument&) {
        return std::nullopt;
    }
}

std::optional<Box3> boundsFor(const PhotographSets& sets) {
    const std::optional<Box3> start = whereAllLook(sets.poses);
    if (!start) return start;
    const std::vector<MatteReport>& mattes = sets.used.mattes;
    const auto isEmpty = [](const MatteReport& matte) { return matte.covered == 0; };
    if (std::none_of(mattes.begin(), mattes.end(), isEmpty)) return boundsOf(sets.used.views, *start);
    std::vector<Photograph> showing;
    for (std::size_t n = 0; n < mattes.size(); ++n)
        if (!isEmpty(mattes[n])) showing.push_back(sets.used.views[n]);
    return boundsOf(showing, *start);
}

}  // namespace

void PhotographSetOptions::validate() const {
    photographs.validate();
    requireField(holdOut == 0 || holdOut >= 2, "holdOut", holdOut, "0 (none) or at least 2");
}

PhotographSets readPhotographSets(const std::string& input, const PhotographSetOptions& options,
                                  const ProgressCallback& progress) {
    const Timer timer;
    options.validate();
    PhotographSets sets;
    const Poses all = readPoses(input, options.poses);
    checkLooking(all, options, sets.warnings);
    sets.matting = mattingFor(all, options);
    const Poses test = readTestPoses(options, all.axes);
    Split parts = split(all, options.holdOut);
    sets.poses = std::move(parts.used);
    PhotographOptions photographs = options.photographs;
    photographs.matting.matting = sets.matting;
    PhotographOptions ofTest = photographs;
    if (!ofTest.matteFolder.empty())  // pictures of both may have the same names
        ofTest.matteFolder = (std::filesystem::path(ofTest.matteFolder) / "test").string();
    sets.complete = readSet(sets.poses, photographs, progress, sets.used, sets.warnings) &&
                    readSet(parts.heldOut, photographs, progress, sets.heldOut, sets.warnings) &&
                    readSet(test, ofTest, progress, sets.test, sets.warnings);
    if (!sets.complete) sets.used = sets.heldOut = sets.test = {};
    sets.bounds = options.bounds || !sets.complete ? options.bounds : boundsFor(sets);
    warnOfEdges(sets, sets.warnings);
    if (options.bounds) warnOfBounds(*options.bounds, sets, sets.warnings);
    if (sets.poses.views.size() == 1)
        sets.warnings.push_back("there is one view only: nothing says how far away what it shows is");
    sets.seconds = timer.seconds();
    return sets;
}

}  // namespace raysweep
