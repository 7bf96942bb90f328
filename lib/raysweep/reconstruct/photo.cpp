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

/// Edge of the voxels. @throw InvalidArgument unless they are cubes along the world's axes
double edgeOf(const openvdb::FloatGrid& reference) {
    const auto& transform = reference.transform();
    const double edge = transform.voxelSize().x();
    const openvdb::Vec3d origin = transform.indexToWorld(openvdb::Vec3d(0.0));
    for (int axis = 0; axis < 3; ++axis) {
        openvdb::Vec3d step(0.0);
        step[axis] = 1;
        openvdb::Vec3d beside = transform.indexToWorld(step) - origin;
        beside[axis] -= edge;
        if (!transform.isLinear() || beside.length() > 1e-6 * edge)
            throw InvalidArgument("the reference's voxels are no cubes along the world's axes");
    }
    return edge;
}

/// Voxels of the reference, around all of `box`.
ReconstructionGrid gridOn(const openvdb::FloatGrid& reference, const Box3& box) {
    ReconstructionGrid grid;
    grid.spacing = edgeOf(reference);
    const openvdb::Vec3d low = reference.transform().worldToIndex({box.min.x, box.min.y, box.min.z});
    const Vec3 size = box.size();
    openvdb::Vec3d middle(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        const double first = std::floor(low[axis] + 0.5 + 1e-6);
        grid.dims[axis] = wholeBricks(low[axis] + size[axis] / grid.spacing - (first - 0.5));
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
    if (options.grid) return *options.grid;
    if (options.reference) {
        const openvdb::FloatGrid& reference = *options.reference->density;
        return gridOn(reference, options.box ? *options.box : activeBox(reference));
    }
    const Box3 box = options.box ? *options.box : boundsOf(photographs);
    return photoGrid(box, resolutionOf(options));
}

/// Sums of squares of differences.
struct Squares {
    double opacity = 0, color = 0;
    void operator+=(const Squares& other) { opacity += other.opacity, color += other.color; }
};

/// Adds what `result` differs from the reference by, over all voxels of the grid, to the last point.
void compare(const ColorVolume& reference, const ReconstructionGrid& grid, PhotoReconstruction& result) {
    if (result.history.empty()) return;
    const openvdb::FloatGrid::Ptr known = opacityGrid(*reference.density);
    const openvdb::Vec3d origin = result.density->indexToWorld(Coord(0));
    const Coord shift = Coord::round(known->transform().worldToIndex(origin));
    const openvdb::Vec3STree &color = result.color->tree(), &knownColor = reference.color->tree();
    const openvdb::CoordBBox all(Coord(0), Coord(grid.dims.x - 1, grid.dims.y - 1, grid.dims.z - 1));
    const auto difference = [&](const Coord& at, float alpha, float knownAlpha) {
        const openvdb::Vec3d c =
            openvdb::Vec3d(color.getValue(at)) * alpha - openvdb::Vec3d(knownColor.getValue(at + shift)) * knownAlpha;
        return Squares{double(alpha - knownAlpha) * (alpha - knownAlpha), c.lengthSqr() / 3};
    };
    Squares sum = sumOverActive<Squares>(*result.opacity, [&](Squares& to, float alpha, const openvdb::CoordBBox& box) {
        for (const Coord& at : box) to += difference(at, alpha, known->tree().getValue(at + shift));
    });
    sum += sumOverActive<Squares>(*known, [&](Squares& to, float alpha, const openvdb::CoordBBox& box) {
        for (const Coord& at : box)
            if (all.isInside(at - shift) && !result.opacity->tree().isValueOn(at - shift))
                to += difference(at - shift, 0, alpha);
    });
    const double voxels = double(grid.dims.x) * grid.dims.y * grid.dims.z;
    result.history.back().opacity = std::sqrt(sum.opacity / voxels);
    result.history.back().color = std::sqrt(sum.color / voxels);
}

double pixelCount(const std::vector<Photograph>& photographs) {
    double count = 0;
    for (const Photograph& photograph : photographs) count += double(photograph.matte.width) * photograph.matte.height;
    return count;
}

std::vector<PhotoPoint> historyOf(const PhotoFitResult& from) {
    std::vector<PhotoPoint> history;
    for (const PhotoFitPoint& point : from.history) {
        PhotoPoint all;
        all.updates = point.updates;
        all.seconds = point.seconds;
        all.resolution = point.resolution;
        all.imageError = std::pow(10, -point.fitted / 20);
        all.leftOut = std::pow(10, -point.leftOut / 20);
        history.push_back(all);
    }
    return history;
}

PhotoTermination terminationOf(PhotoFitTermination termination) {
    switch (termination) {
        case PhotoFitTermination::interrupted:
            return PhotoTermination::interrupted;
        case PhotoFitTermination::overfitted:
            return PhotoTermination::overfitted;
        default:
            return PhotoTermination::iterations;
    }
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
    const PhotoFitResult from = fitPhotographs(photographs, fit, progress);
    PhotoReconstruction to;
    to.density = from.density;
    to.opacity = from.opacity;
    to.color = extendedColor(*from.color, *from.density);
    to.history = historyOf(from);
    if (!to.history.empty()) to.updates = to.history.back().updates;
    to.termination = terminationOf(from.termination);
    to.resolution = from.resolution;
    to.timings = {from.timings.prepared, 0, from.timings.updates, from.timings.total};
    to.keptVoxels = from.keptVoxels;
    to.samples = from.samples;
    to.poses = from.poses;
    if (options.reference) compare(*options.reference, grid, to);
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
