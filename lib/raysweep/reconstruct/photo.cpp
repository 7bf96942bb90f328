#include "raysweep/reconstruct/photo.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/photo_hull.h"
#include "raysweep/reconstruct/photo_light.h"
#include "raysweep/volume/active_values.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

using openvdb::Coord;

constexpr int kBrick = 8;  ///< along an edge of the grid there is a whole number of them

/// fit: small sets get smaller updates, such that there are so many in a pass; derivatives of fewer rays are noise.
constexpr int kFewestUpdates = 64, kFewestRays = 512;

int wholeBricks(double voxels) {
    return std::max(1, int(std::ceil(voxels / kBrick - 1e-6))) * kBrick;
}

ReconstructionGrid gridIn(const Box3& box, int resolution) {
    const Vec3 size = box.size();
    ReconstructionGrid grid;
    const int most = wholeBricks(resolution);
    grid.spacing = std::max({size.x, size.y, size.z}) / most;
    grid.center = box.center();
    for (int axis = 0; axis < 3; ++axis) grid.dims[axis] = std::min(most, wholeBricks(size[axis] / grid.spacing));
    return grid;
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

Box3 boxOf(const ReconstructionGrid& grid) {
    const Vec3 half = Vec3(grid.dims.x, grid.dims.y, grid.dims.z) * (0.5 * grid.spacing);
    return Box3(grid.center - half, grid.center + half);
}

Box3 activeBox(const openvdb::FloatGrid& reference) {
    const openvdb::CoordBBox active = reference.evalActiveVoxelBoundingBox();
    if (active.empty()) throw InvalidArgument("the reference has no active voxels");
    const openvdb::Vec3d low = reference.indexToWorld(active.min().asVec3d() - 0.5),
                         high = reference.indexToWorld(active.max().asVec3d() + 0.5);
    return Box3(Vec3(low.x(), low.y(), low.z()), Vec3(high.x(), high.y(), high.z()));
}

ReconstructionGrid gridFor(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                           const ColorVolume* reference) {
    if (reference) return gridOn(*reference->density, options.box ? *options.box : activeBox(*reference->density));
    return gridIn(options.box ? *options.box : photographedBox(photographs, float(options.fit.hullThreshold)),
                  options.resolution);
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

PhotoReconstruction byFit(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                          const ReconstructionGrid& grid, const ColorVolume* reference,
                          const ProgressCallback& progress) {
    PhotoFitOptions fit = options.fit;
    fit.box = boxOf(grid);
    fit.resolution = std::max({grid.dims.x, grid.dims.y, grid.dims.z});
    fit.seed = options.seed;
    fit.raysPerUpdate = int(
        std::min<double>(fit.raysPerUpdate, std::max<double>(kFewestRays, pixelCount(photographs) / kFewestUpdates)));
    PhotoFitResult found = fitPhotographs(photographs, fit, progress);
    PhotoReconstruction result;
    result.density = found.density;
    result.opacity = found.opacity;
    result.color = extendedColor(*found.color, *found.density);
    for (const PhotoFitPoint& point : found.history)
        result.history.push_back({point.updates, point.seconds, point.resolution, std::pow(10, -point.fitted / 20)});
    if (found.termination == PhotoFitTermination::interrupted) result.termination = PhotoTermination::interrupted;
    result.timings.prepared = found.timings.prepared;
    result.timings.updates = found.timings.updates;
    result.updates = found.history.empty() ? 0 : found.history.back().updates;
    result.keptVoxels = found.keptVoxels;
    result.samples = found.samples;
    if (reference) compare(*reference, grid, result);
    return result;
}

PhotoReconstruction byCorrections(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                                  const ReconstructionGrid& grid, const ColorVolume* reference,
                                  const ProgressCallback& progress) {
    PhotoSartOptions sart = options.sart;
    sart.form = options.method == PhotoMethod::paper ? PhotoForm::paper : PhotoForm::consistent;
    sart.seed = options.seed;
    const Timer timer;
    std::optional<PhotoLight> light;
    if (options.searchLight) {
        light = findLight(photographs, grid, {}, progress);
        sart.light = {light->shading, true};
    }
    const double searched = timer.seconds();
    PhotoReconstruction result = photoSart(photographs, grid, sart, {nullptr, reference}, progress);
    result.light = light;
    result.timings.light = searched;
    return result;
}

}  // namespace

void PhotoOptions::validate() const {
    requireField(resolution >= 8 && resolution <= 1024, "resolution", resolution, "in [8,1024]");
    if (method == PhotoMethod::fit) {
        fit.validate();
        if (searchLight || sart.light.shading.diffuse > 0)
            throw InvalidArgument(
                "a fit takes colours as they are seen; to take light out of them, choose another method");
    } else {
        sart.validate();
    }
}

PhotoReconstruction reconstructPhotographs(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                                           const ColorVolume* reference, const ProgressCallback& progress) {
    const Timer timer;
    options.validate();
    if (photographs.empty()) throw InvalidArgument("there are no photographs to make a volume of");
    const ReconstructionGrid grid = gridFor(photographs, options, reference);
    grid.validate();
    PhotoReconstruction result = options.method == PhotoMethod::fit
                                     ? byFit(photographs, options, grid, reference, progress)
                                     : byCorrections(photographs, options, grid, reference, progress);
    result.timings.total = timer.seconds();
    return result;
}

}  // namespace raysweep
