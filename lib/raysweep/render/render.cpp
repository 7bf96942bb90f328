/// Dachille, Mueller, Kaufman, "Volumetric Global Illumination and Reconstruction via Energy Backprojection", 2000,
/// section 2.3: L = sum over steps of S T (1 - exp(-sigma ds)) + T background, front to back.

#include "raysweep/render/render.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/render/occupancy.h"
#include "raysweep/render/sampler.h"
#include "raysweep/volume/voxel_check.h"

#include <openvdb/math/DDA.h>
#include <openvdb/math/Ray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>

namespace raysweep {
namespace {

using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Mat4d;
using openvdb::Vec3d;
using openvdb::Vec3SGrid;

constexpr int kTileSide = 16;       // pixels; rays of one tile meet the same nodes
constexpr int kTilesPerGroup = 64;  // between two calls of the progress callback

Vec3d toVdb(const Vec3& v) {
    return Vec3d(v.x, v.y, v.z);
}
void add(Color& sum, float weight, float s) {
    sum += grey(weight * s);
}
void add(Color& sum, float weight, const openvdb::Vec3s& s) {
    sum += Color(s.x(), s.y(), s.z()) * weight;
}

/// 1 - exp(-tau) without cancellation for small tau: a step through thin smoke has tau far below a float's epsilon.
float opacityOf(float tau) {
    if (tau < 0.0625f) return tau * (1 - tau * (0.5f - tau * (1 / 6.f - tau * (1 / 24.f))));
    return 1 - std::exp(-tau);
}

Mat4d affineMatrix(const openvdb::GridBase& grid, const char* name) {
    if (!grid.transform().isLinear())
        throw InvalidArgument(std::string(name) + " grid '" + grid.getName() +
                              "' has a perspective transform; resample it to a linear one first");
    return grid.transform().baseMap()->getAffineMap()->getMat4();
}

/// A ray in a grid's index space: o + t d.
struct IndexLine {
    Vec3d origin, direction;
    IndexLine(const Mat4d& indexFromWorld, const Vec3d& o, const Vec3d& d)
        : origin(indexFromWorld.transform(o)), direction(indexFromWorld.transform3x3(d)) {}
    Vec3d at(double t) const { return origin + direction * t; }
};

/// All that is the same for every ray.
template <class RadiosityGrid>
struct Scene {
    const FloatGrid& density;
    const RadiosityGrid& radiosity;
    const FloatTree& occupied;
    openvdb::CoordBBox bounds;  // of `occupied`, exclusive at its upper end
    Mat4d densityFromWorld, radiosityFromWorld;
    double extinctionScale;
    const RenderOptions& options;
};

/// What a ray has gathered so far.
struct RayState {
    Color radiance = grey(0);
    double transmittance = 1;
};

/// Follows rays one after another; owns what a thread needs for it.
template <class RadiosityGrid>
class RayMarcher {
  public:
    explicit RayMarcher(const Scene<RadiosityGrid>& scene)
        : scene_(scene),
          density_(scene.density),
          around_(scene.density),
          radiosity_(scene.radiosity),
          occupied_(scene.occupied) {}

    RayState follow(const Ray& ray) {
        RayState state;
        if (!start(ray)) return state;
        IndexRay segment = ray_;
        while (segment.valid()) {
            const auto span = hdda_.march(segment, occupied_);
            if (!span.valid() || !crossSpan(span.t0, span.t1, state)) break;
            // A nudge, so that rounding does not find the same end again.
            segment = ray_;
            segment.setTimes(std::min(span.t1 + openvdb::math::Delta<double>::value(), ray_.t1()), ray_.t1());
        }
        return state;
    }

  private:
    using IndexRay = openvdb::math::Ray<double>;

    /// Sets up the ray in index space, t being the length there, so that one step is the same number of voxels in
    /// every direction. @return false if the ray misses the volume.
    bool start(const Ray& ray) {
        if (scene_.bounds.empty()) return false;
        const Vec3d origin = toVdb(ray.origin);
        Vec3d direction = toVdb(ray.direction);
        worldPerIndex_ = 1 / scene_.densityFromWorld.transform3x3(direction).length();
        direction *= worldPerIndex_;
        line_ = IndexLine(scene_.densityFromWorld, origin, direction);
        radiosityLine_ = IndexLine(scene_.radiosityFromWorld, origin, direction);
        ray_ = IndexRay(line_.origin, line_.direction, 0.0);
        if (!ray_.clip(scene_.bounds)) return false;
        // Start over near the volume, a whole number of steps on: the samples stay where they are, but an eye far away
        // costs no digits.
        const double step = scene_.options.step, skipped = std::floor(ray_.t0() / step) * step;
        line_.origin = line_.at(skipped);
        radiosityLine_.origin = radiosityLine_.at(skipped);
        ray_ = IndexRay(line_.origin, line_.direction, ray_.t0() - skipped, ray_.t1() - skipped);
        stepDepth_ = float(scene_.extinctionScale * step * worldPerIndex_);
        nextStep_ = 0;
        return true;
    }

    /// Takes the steps that touch [t0,t1] and were not taken yet. @return false when the ray is as good as dark.
    bool crossSpan(double t0, double t1, RayState& state) {
        const double step = scene_.options.step;
        const auto end = std::int64_t(std::ceil(t1 / step));
        for (std::int64_t k = std::max(nextStep_, std::int64_t(std::floor(t0 / step))); k < end; ++k)
            if (!takeStep((double(k) + 0.5) * step, state)) return false;
        nextStep_ = std::max(nextStep_, end);
        return true;
    }

    bool takeStep(double t, RayState& state) {
        const Vec3d p = line_.at(t);
        const float density = density_(p);
        if (!(density > 0)) return true;
        const float opacity = opacityOf(density * stepDepth_);
        const float weight = float(state.transmittance) * opacity;
        add(state.radiance, scene_.options.lambert ? weight * cosine(p) : weight, radiosity_(radiosityLine_.at(t)));
        state.transmittance *= 1 - double(opacity);
        if (state.transmittance > scene_.options.minTransmittance) return true;
        state.radiance *= float(1 / (1 - state.transmittance));
        state.transmittance = 0;
        return false;
    }

    /// max(0, -d.n) with n = -grad sigma / |grad sigma|, in world space.
    float cosine(const Vec3d& p) {
        Vec3d slope;  // along the axes of index space, per voxel
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d ahead = p, behind = p;
            ahead[axis] += 1, behind[axis] -= 1;
            slope[axis] = 0.5 * (double(around_(ahead)) - around_(behind));
        }
        // grad_world_j = sum_i d index_i / d world_j slope_i; OpenVDB's matrices stand to the right of row vectors.
        const Mat4d& m = scene_.densityFromWorld;
        Vec3d gradient;
        for (int j = 0; j < 3; ++j) gradient[j] = m[j][0] * slope[0] + m[j][1] * slope[1] + m[j][2] * slope[2];
        const double length = gradient.length();
        if (!(slope.length() > 1e-6 * density_(p)) || !(length > 0)) return 1;
        const double alongRay = slope.dot(line_.direction) / worldPerIndex_;  // d . grad sigma
        return float(std::max(0.0, alongRay / length));
    }

    const Scene<RadiosityGrid>& scene_;
    LinearSampler<FloatGrid> density_, around_;
    LinearSampler<RadiosityGrid> radiosity_;
    openvdb::tree::ValueAccessor<const FloatTree, false> occupied_;
    openvdb::math::VolumeHDDA<FloatTree, IndexRay, FloatTree::RootNodeType::ChildNodeType::LEVEL> hdda_;
    IndexLine line_{Mat4d::identity(), Vec3d(0.0), Vec3d(0.0)}, radiosityLine_ = line_;
    IndexRay ray_;
    double worldPerIndex_ = 1;
    float stepDepth_ = 0;  // optical depth of a step through density 1
    std::int64_t nextStep_ = 0;
};

template <class RadiosityGrid>
void renderPixel(RayMarcher<RadiosityGrid>& marcher, const CameraFrame& frame, const RenderOptions& options, int x,
                 int y, float* pixel) {
    Color radiance = grey(0);
    double transmittance = 0;
    const int n = options.samples;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const RayState state = marcher.follow(pixelRay(frame, x + (i + 0.5) / n, y + (j + 0.5) / n));
            radiance += state.radiance + options.background * float(state.transmittance);
            transmittance += state.transmittance;
        }
    const float share = 1 / float(n * n);
    for (int c = 0; c < 3; ++c) pixel[c] = radiance[c] * share;
    pixel[3] = float(1 - transmittance / (n * n));
}

/// @return false if stopped by `progress`.
template <class RadiosityGrid>
bool renderTiles(const Scene<RadiosityGrid>& scene, const CameraFrame& frame, const ProgressCallback& progress,
                 Image& image) {
    const int across = (image.width + kTileSide - 1) / kTileSide, down = (image.height + kTileSide - 1) / kTileSide;
    const std::size_t count = std::size_t(across) * down;
    const auto renderTile = [&](std::size_t tile) {
        RayMarcher<RadiosityGrid> marcher(scene);
        const int x0 = int(tile % across) * kTileSide, y0 = int(tile / across) * kTileSide;
        for (int y = y0; y < std::min(y0 + kTileSide, image.height); ++y)
            for (int x = x0; x < std::min(x0 + kTileSide, image.width); ++x)
                renderPixel(marcher, frame, scene.options, x, y, image.at(x, y));
    };
    for (std::size_t begin = 0; begin < count; begin += kTilesPerGroup) {
        if (!report(progress, "render", double(begin) / double(count))) return false;
        parallelFor(std::min<std::size_t>(kTilesPerGroup, count - begin),
                    [&](std::size_t i) { renderTile(begin + i); });
    }
    report(progress, "render", 1);
    return true;
}

template <class RadiosityGrid>
bool renderGrid(const RenderInput& input, const FloatGrid& density, const RadiosityGrid& radiosity,
                const CameraFrame& frame, const RenderOptions& options, const ProgressCallback& progress,
                Image& image) {
    checkVoxels(*input.density, "density");
    checkVoxels(radiosity, "radiosity");
    const FloatTree::Ptr occupied = occupancy(density);
    openvdb::CoordBBox bounds;
    occupied->evalActiveVoxelBoundingBox(bounds);
    if (!bounds.empty()) bounds.max().offset(1);
    const Scene<RadiosityGrid> scene{density,
                                     radiosity,
                                     *occupied,
                                     bounds,
                                     affineMatrix(density, "density").inverse(),
                                     affineMatrix(radiosity, "radiosity").inverse(),
                                     input.extinctionScale,
                                     options};
    return renderTiles(scene, frame, progress, image);
}

void requireInput(const RenderInput& input) {
    if (!input.density) throw InvalidArgument("render: no density grid is given");
    if (!input.radiosity) throw InvalidArgument("render: no radiosity grid is given; light the volume first");
    if (!(input.extinctionScale >= 0 && std::isfinite(input.extinctionScale))) {
        std::ostringstream message;
        message << "extinctionScale " << input.extinctionScale << ": must be finite and not negative";
        throw InvalidArgument(message.str());
    }
}

}  // namespace

void RenderOptions::validate() const {
    const auto require = [](bool good, const char* field, double value, const char* bound) {
        if (good) return;
        std::ostringstream message;
        message << field << " " << value << ": must " << bound;
        throw InvalidArgument(message.str());
    };
    require(step > 0 && step <= 8, "step", step, "be above 0 and at most 8 voxels");
    require(samples >= 1 && samples <= 64, "samples", samples, "lie between 1 and 64 per side of a pixel");
    require(minTransmittance >= 0 && minTransmittance < 1, "minTransmittance", minTransmittance, "be in [0,1)");
    for (int c = 0; c < 3; ++c)
        require(background[c] >= 0 && std::isfinite(background[c]), "background", background[c],
                "be finite and not negative");
}

RenderResult render(const RenderInput& input, const Camera& camera, const RenderOptions& options,
                    const ProgressCallback& progress) {
    const Timer timer;
    requireInput(input);
    options.validate();
    const CameraFrame frame = cameraFrame(camera);
    const FloatGrid::ConstPtr density = zeroWhereInactive(input.density);
    RenderResult result;
    result.image = Image(camera.width, camera.height, 4);
    if (const auto grey = openvdb::gridConstPtrCast<FloatGrid>(input.radiosity))
        result.complete = renderGrid(input, *density, *grey, frame, options, progress, result.image);
    else if (const auto coloured = openvdb::gridConstPtrCast<Vec3SGrid>(input.radiosity))
        result.complete = renderGrid(input, *density, *coloured, frame, options, progress, result.image);
    else
        throw InvalidArgument("radiosity grid '" + input.radiosity->getName() + "' is of type " +
                              input.radiosity->type() + "; it must hold floats or vec3s");
    result.seconds = timer.seconds();
    return result;
}

Box3 worldBounds(const openvdb::GridBase& grid) {
    Box3 bounds;
    const openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
    if (active.empty()) return bounds;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3d p;
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = corner >> axis & 1 ? active.max()[axis] + 0.5 : active.min()[axis] - 0.5;
        p = grid.indexToWorld(p);
        bounds.extendBy(Vec3(p.x(), p.y(), p.z()));
    }
    return bounds;
}

}  // namespace raysweep
