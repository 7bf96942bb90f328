#include "raysweep/reconstruct/photo.h"

#include "raysweep/camera/object_bounds.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/photo_views.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace raysweep {
namespace {

int passesOf(const PhotoOptions& options) {
    if (options.iterations > 0) return options.iterations;
    return options.method == PhotoMethod::consistent ? 4 : 12;
}

/// Where all cameras look, as far as silhouettes leave it.
Box3 shownBox(const std::vector<Photograph>& photographs) {
    std::vector<Pose> poses;
    for (const Photograph& photograph : photographs) {
        Pose pose;
        pose.camera = photograph.camera;
        poses.push_back(pose);
    }
    return boundsOf(photographs, boundsSeenByAll(poses));
}

ReconstructionGrid gridFor(const std::vector<Photograph>& photographs, const PhotoOptions& options) {
    if (options.grid) return *options.grid;
    if (options.reference && !options.box) return reconstructionGrid({}, {}, options.reference->density.get());
    const Box3 box = options.box ? *options.box : shownBox(photographs);
    return photoGrid(box, options.resolution);
}

PhotoReconstruction fitted(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                           const ProgressCallback& progress) {
    PhotoFitOptions fit = options.fit;
    fit.passes = passesOf(options);
    fit.resolution = options.resolution;
    fit.box = options.box;
    if (options.grid) {
        const Vec3 half =
            Vec3(options.grid->dims.x, options.grid->dims.y, options.grid->dims.z) * (0.5 * options.grid->spacing);
        fit.box = Box3(options.grid->center - half, options.grid->center + half);
        fit.resolution = std::max({options.grid->dims.x, options.grid->dims.y, options.grid->dims.z});
    }
    const PhotoFitResult from = fitPhotographs(photographs, fit, progress);
    PhotoReconstruction to;
    to.density = from.density;
    to.opacity = from.opacity;
    to.color = from.color;
    for (const PhotoFitPoint& point : from.history) {
        PhotoPoint all;
        all.updates = point.updates;
        all.seconds = point.seconds;
        all.resolution = point.resolution;
        all.imageError = std::pow(10, -point.fitted / 20);
        to.history.push_back(all);
    }
    if (!to.history.empty()) to.updates = to.history.back().updates;
    if (from.termination == PhotoFitTermination::interrupted) to.termination = PhotoTermination::interrupted;
    to.timings = {from.timings.prepared, 0, from.timings.updates, from.timings.total};
    to.keptVoxels = from.keptVoxels;
    to.samples = from.samples;
    return to;
}

PhotoReconstruction corrected(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                              const ProgressCallback& progress) {
    const Timer timer;
    const ReconstructionGrid grid = gridFor(photographs, options);
    PhotoSartOptions sart;
    sart.form = options.method == PhotoMethod::paper ? PhotoForm::paper : PhotoForm::consistent;
    sart.iterations = passesOf(options);
    sart.relaxation = options.relaxation;
    sart.historyEvery = options.historyEvery;
    sart.light = options.light;
    std::optional<PhotoLight> light;
    double searched = 0;
    if (options.findLight) {
        const Timer search;
        light = findLight(photographs, grid, options.lightSearch, progress);
        searched = search.seconds();
        if (light) sart.light.shading = light->shading;
    }
    const bool stopped = options.findLight && !light;
    const ProgressCallback stop = [](const std::string&, double) { return false; };
    PhotoVolumes volumes;
    if (options.reference) volumes.reference = &*options.reference;
    PhotoReconstruction result = photoSart(photographs, grid, sart, volumes, stopped ? stop : progress);
    result.light = light;
    result.timings.light = searched;
    result.timings.total = timer.seconds();
    return result;
}

}  // namespace

void PhotoOptions::validate() const {
    requireField(iterations >= 0, "iterations", iterations, "at least 0");
    requireField(relaxation > 0 && relaxation <= 2, "relaxation", relaxation, "in (0,2]");
    requireField(resolution >= 16 && resolution <= 1024 && resolution % 8 == 0, "resolution", resolution,
                 "a multiple of 8, from 16 to 1024");
    requireField(historyEvery >= 0, "historyEvery", historyEvery, "at least 0");
    light.shading.validate();
    lightSearch.validate();
    if (grid) grid->validate();
    if (findLight && !light.turns)
        throw InvalidArgument("light that stays with the object cannot be found: from all sides it looks the same");
    if (method == PhotoMethod::fit && (findLight || light.shading.diffuse > 0))
        throw InvalidArgument(
            "the fit takes colours as they are seen; choose another method where light is known or "
            "to be found");
    if (method == PhotoMethod::fit) fit.validate();
}

PhotoReconstruction reconstructPhotographs(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                                           const ProgressCallback& progress) {
    options.validate();
    return options.method == PhotoMethod::fit ? fitted(photographs, options, progress)
                                              : corrected(photographs, options, progress);
}

}  // namespace raysweep
