#include "raysweep/reconstruct/photo.h"

#include "raysweep/camera/object_bounds.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/photo_views.h"
#include "raysweep/volume/active_values.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace raysweep {
namespace {

using openvdb::Coord;

constexpr int kBrick = 8;  ///< along an edge of the grid there is a whole number of them

/// fit: small sets get smaller updates, such that there are so many in a pass; derivatives of fewer rays are noise.
constexpr int kFewestUpdates = 64, kFewestRays = 512;

int wholeBricks(double voxels) {
    return std::max(1, int(std::ceil(voxels / kBrick - 1e-6))) * kBrick;
}

/// consistent, paper
int passesOf(const PhotoOptions& options) {
    if (options.iterations > 0) return options.iterations;
    return options.method == PhotoMethod::consistent ? 4 : 12;
}

int resolutionOf(const PhotoOptions& options) {
    if (options.resolution > 0) return options.resolution;
    return options.method == PhotoMethod::fit ? options.fit.resolution : 128;
}

/// Voxels of the reference, around all of `box`.
ReconstructionGrid gridOn(const openvdb::FloatGrid& reference, const Box3& box) {
    ReconstructionGrid grid;
    const std::optional<double> edge = edgeOfCubes(reference.transform());
    if (!edge) throw InvalidArgument("the reference's voxels are no cubes along the world's axes");
    grid.spacing = Vec3(*edge);
    const openvdb::Vec3d low = reference.transform().worldToIndex({box.min.x, box.min.y, box.min.z});
    const Vec3 size = box.size();
    openvdb::Vec3d middle(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        const double first = std::floor(low[axis] + 0.5 + 1e-6);
        grid.dims[axis] = wholeBricks(low[axis] + size[axis] / grid.edge() - (first - 0.5));
        middle[axis] = first + 0.5 * (grid.dims[axis] - 1);
    }
    const openvdb::Vec3d center = reference.transform().indexToWorld(middle);
    grid.center = Vec3(center.x(), center.y(), center.z());
    return grid;
}

Box3 activeBox(const openvdb::FloatGrid& reference) {
    const openvdb::CoordBBox active = reference.evalActiveVoxelBoundingBox();
    if (active.empty()) throw InvalidArgument("the reference has no active voxels");
    const openvdb::Vec3d low = reference.indexToWorld(active.min().asVec3d() - 0.5),
                         high = reference.indexToWorld(active.max().asVec3d() + 0.5);
    return Box3(Vec3(low.x(), low.y(), low.z()), Vec3(high.x(), high.y(), high.z()));
}

ReconstructionGrid gridFor(const std::vector<Photograph>& photographs, const PhotoOptions& options) {
    if (options.grid) {
        options.grid->requireCubes();
        return *options.grid;
    }
    if (options.reference) {
        const openvdb::FloatGrid& reference = *options.reference->density;
        return gridOn(reference, options.box ? *options.box : activeBox(reference));
    }
    const Box3 box = options.box ? *options.box : boundsOf(photographs);
    return photoGrid(box, resolutionOf(options));
}

double pixelCount(const std::vector<Photograph>& photographs) {
    double count = 0;
    for (const Photograph& photograph : photographs) count += double(photograph.matte.width) * photograph.matte.height;
    return count;
}

PhotoReconstruction fitted(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                           const ProgressCallback& progress) {
    const ReconstructionGrid grid = gridFor(photographs, options);
    PhotoFitOptions fit = options.fit;
    if (options.iterations > 0) fit.passes = options.iterations;
    fit.box = grid.box();
    fit.resolution = grid.resolution();
    fit.seed = options.seed;
    fit.raysPerUpdate = int(
        std::min<double>(fit.raysPerUpdate, std::max<double>(kFewestRays, pixelCount(photographs) / kFewestUpdates)));
    return fitPhotographs(photographs, fit, options.reference ? &*options.reference : nullptr, progress);
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
    sart.seed = options.seed;
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
    result.resolution = grid.resolution();
    result.light = light;
    result.timings.light = searched;
    result.timings.total = timer.seconds();
    return result;
}

}  // namespace

void PhotoOptions::validate() const {
    requireField(iterations >= 0, "iterations", iterations, "at least 0");
    requireField(relaxation > 0 && relaxation <= 2, "relaxation", relaxation, "in (0,2]");
    requireField(resolution == 0 || (resolution >= 16 && resolution <= 1024 && resolution % 8 == 0), "resolution",
                 resolution, "a multiple of 8, from 16 to 1024, or 0");
    requireField(historyEvery >= 0, "historyEvery", historyEvery, "at least 0");
    light.shading.validate();
    lightSearch.validate();
    if (grid) grid->validate();
    if (findLight && !light.turns)
        throw InvalidArgument("light that stays with the object cannot be found: from all sides it looks the same");
    const bool lit = findLight || light.shading.diffuse > 0 || light.shading.ambient != 1;
    if (method == PhotoMethod::fit && lit)
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
