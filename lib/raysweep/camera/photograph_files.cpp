#include "raysweep/camera/photograph_files.h"

#include "raysweep/camera/picture_folders.h"
#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/matte_picture.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <functional>
#include <set>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

using Matting = MattingOptions::Matting;

constexpr double kManyInconsistent = 0.01;  ///< of a view's object
constexpr std::size_t kNamed = 3;           ///< views that a warning names

/// What a view is called: its picture, or the first there is.
const std::string& nameOf(const Pose& pose) {
    return !pose.image.empty() ? pose.image : !pose.onWhite.empty() ? pose.onWhite : pose.onBlack;
}

/// Files of a view; `partner` is empty if the method needs one picture.
struct ViewFiles {
    std::string picture, partner;
};

/// By the picture's name with its folder's, its name alone, and its name with another extension.
std::string maskOf(const Pose& pose, const std::string& folder) {
    if (folder.empty()) {
        if (pose.mask.empty())
            throw InvalidArgument("no mask is named for '" + nameOf(pose) + "'; say in which folder masks are");
        return pose.mask;
    }
    const fs::path picture = nameOf(pose), within = picture.parent_path().filename() / picture.filename();
    try {
        return findPicture({folder, {}}, within.string());
    } catch (const IoError&) {
        return findPicture({folder, {}}, fs::path(within).replace_extension().string());
    }
}

ViewFiles filesOf(const Pose& pose, const PhotographOptions& options) {
    const auto given = [&](const std::string& file, const char* what) {
        if (file.empty())
            throw InvalidArgument("the view '" + nameOf(pose) + "' has no picture " + what +
                                  "; leave the view out, or choose another way to find the object");
        return file;
    };
    switch (options.matting.matting) {
        case Matting::whiteBlack:
            return {given(pose.onWhite, "before a white backdrop"), given(pose.onBlack, "before a black backdrop")};
        case Matting::white:
            return {given(pose.onWhite.empty() ? pose.image : pose.onWhite, "before a white backdrop"), ""};
        case Matting::black:
            return {given(pose.onBlack.empty() ? pose.image : pose.onBlack, "before a black backdrop"), ""};
        case Matting::masks:
            return {given(pose.image, "of its own"), maskOf(pose, options.maskFolder)};
        default:
            return {given(pose.image, "of its own"), ""};
    }
}

/// A file's name for each view's matte: that of its picture, with a number where several have the same.
std::vector<std::string> matteNames(const Poses& poses) {
    std::set<std::string> taken;
    std::vector<std::string> names;
    for (const Pose& pose : poses.views) {
        const std::string stem = fs::path(nameOf(pose)).stem().string();
        std::string name = stem;
        for (int number = 2; !taken.insert(name).second; ++number) name = stem + "-" + std::to_string(number);
        names.push_back(name + ".png");
    }
    return names;
}

/// Reads one view. @param matteFile where the picture of its matte is written; empty: nowhere
Photograph readView(const Pose& pose, const PhotographOptions& options, const std::string& matteFile,
                    MatteReport& report) {
    const ViewFiles files = filesOf(pose, options);
    MattingInput input;
    input.picture = readImage(files.picture);
    const PhotoCamera camera = matchedTo(pose.camera, input.picture.width, input.picture.height, files.picture);
    if (!files.partner.empty())
        input.partner =
            options.matting.matting == Matting::masks ? readCoverage(files.partner) : readImage(files.partner);
    try {
        Matte matte = matteOf(input, options.matting);
        report = matte.report;
        if (!matteFile.empty()) writeImage(matteFile, mattePicture(matte.image, matte.inconsistent));
        Photograph photograph{files.picture, camera, std::move(matte.image)};
        return options.reduction > 1 ? reduced(photograph, options.reduction) : photograph;
    } catch (const InvalidArgument& error) {
        throw about(files.picture, error);
    }
}

void requireRoom(const Poses& poses, int reduction) {
    double bytes = 0;
    for (const Pose& pose : poses.views)
        bytes += 4.0 * sizeof(float) * pose.camera.width * pose.camera.height / (double(reduction) * reduction);
    requireBytes(bytes, "the photographs need", "make them smaller, or leave some out");
}

/// "3 of 80 views WHAT: a, b, c"; nothing if there are none.
void warn(std::vector<PhotographWarning>& warnings, PhotographWarning::Kind kind, const Photographs& photographs,
          const std::string& what, const std::function<bool(const MatteReport&)>& concerns) {
    std::string names;
    std::size_t count = 0;
    for (std::size_t n = 0; n < photographs.views.size(); ++n) {
        if (!concerns(photographs.reports[n])) continue;
        if (count < kNamed) names += (count > 0 ? ", '" : "'") + photographs.views[n].name + "'";
        if (count == kNamed) names += ", ...";
        ++count;
    }
    if (count > 0)
        warnings.push_back({kind, std::to_string(count) + " of " + std::to_string(photographs.views.size()) +
                                      " views " + what + ": " + names});
}

std::vector<PhotographWarning> warningsOf(const Photographs& photographs) {
    using Kind = PhotographWarning::Kind;
    std::vector<PhotographWarning> warnings;
    if (photographs.views.size() == 1)
        warnings.push_back({Kind::oneView, "there is one view only: nothing says how far away what it shows is"});
    warn(warnings, Kind::emptyViews, photographs, "show nothing of the object",
         [](const MatteReport& report) { return report.covered == 0; });
    warn(warnings, Kind::fullViews, photographs, "show the object in every pixel, so there is no outline",
         [](const MatteReport& report) { return report.covered == report.pixels; });
    warn(warnings, Kind::inconsistent, photographs,
         "have inconsistent pixels (more than " + brief(100 * kManyInconsistent) + " % of the object)",
         [](const MatteReport& report) {
             return double(report.inconsistent) > kManyInconsistent * double(report.covered);
         });
    int farthest = 0;
    for (const MatteReport& report : photographs.reports)
        if (report.misregistration)
            farthest = std::max({farthest, std::abs(report.misregistration->x), std::abs(report.misregistration->y)});
    warn(warnings, Kind::misregistration, photographs,
         "have pairs of pictures that do not lie on each other (by up to " + std::to_string(farthest) + " pixels)",
         [](const MatteReport& report) { return report.misregistration.has_value(); });
    return warnings;
}

/// Some views at a time, so that the caller's thread can report; of several errors that of the first view is thrown.
/// @return false if it was stopped
bool readViews(const Poses& poses, const PhotographOptions& options, const ProgressCallback& progress,
               Photographs& photographs) {
    const std::size_t views = poses.views.size(), atOnce = std::size_t(threadCount());
    const std::vector<std::string> names = matteNames(poses);
    std::vector<std::exception_ptr> errors(views);
    for (std::size_t first = 0; first < views; first += atOnce) {
        if (!report(progress, "reading photographs", double(first) / double(views))) return false;
        const std::size_t count = std::min(atOnce, views - first);
        parallelFor(count, [&](std::size_t i) {
            const std::size_t n = first + i;
            const std::string matte =
                options.matteFolder.empty() ? "" : (fs::path(options.matteFolder) / names[n]).string();
            try {
                photographs.views[n] = readView(poses.views[n], options, matte, photographs.reports[n]);
            } catch (...) {
                errors[n] = std::current_exception();
            }
        });
        for (std::size_t n = first; n < first + count; ++n)
            if (errors[n]) std::rethrow_exception(errors[n]);
    }
    return true;
}

void requireObject(const Photographs& photographs) {
    const auto isEmpty = [](const MatteReport& report) { return report.covered == 0; };
    if (std::all_of(photographs.reports.begin(), photographs.reports.end(), isEmpty))
        throw InvalidArgument("no view shows the object: nothing is covered in any pixel of " +
                              std::to_string(photographs.views.size()) +
                              " pictures; look at one, and choose another way to tell the object from its backdrop");
}

}  // namespace

void PhotographOptions::validate() const {
    matting.validate();
    requireField(reduction >= 1 && reduction <= 64, "reduction", reduction, "in [1,64]");
}

Photographs readPhotographs(const Poses& poses, const PhotographOptions& options, const ProgressCallback& progress) {
    const Timer timer;
    options.validate();
    if (poses.views.empty()) throw InvalidArgument("there are no views to read photographs of");
    requireRoom(poses, options.reduction);
    for (const Pose& pose : poses.views) filesOf(pose, options);  // what is missing is found before the first is read
    if (!options.matteFolder.empty()) makeOutputFolder(options.matteFolder);
    Photographs photographs;
    photographs.views.resize(poses.views.size());
    photographs.reports.resize(poses.views.size());
    photographs.complete = readViews(poses, options, progress, photographs);
    photographs.seconds = timer.seconds();
    if (!photographs.complete) {
        photographs.views.clear();
        photographs.reports.clear();
        return photographs;
    }
    requireObject(photographs);
    photographs.warnings = warningsOf(photographs);
    return photographs;
}

}  // namespace raysweep
