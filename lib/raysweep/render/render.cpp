#include "raysweep/render/render.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/require.h"
#include "raysweep/render/cell_blocks.h"
#include "raysweep/render/fire_marcher.h"
#include "raysweep/render/occupancy.h"
#include "raysweep/render/ray_marcher.h"
#include "raysweep/volume/voxel_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace raysweep {
namespace {

using openvdb::FloatGrid;
using openvdb::Int32Tree;
using openvdb::Mat4d;
using openvdb::Vec3d;
using openvdb::Vec3SGrid;

constexpr int kBucketSide = 16;       // pixels; rays of one bucket meet the same nodes
constexpr int kBucketsPerGroup = 64;  // between two calls of the progress callback

constexpr double kShortestStep = 0.01;  // voxels: a picture takes as many times longer, and looks the same

void requireLinear(const openvdb::GridBase& grid, const char* name) {
    if (!grid.transform().isLinear())
        throw InvalidArgument(std::string(name) + " grid '" + grid.getName() +
                              "' has a perspective transform; resample it to a linear one first");
}

Mat4d indexFromWorld(const openvdb::GridBase& grid) {
    return grid.transform().baseMap()->getAffineMap()->getMat4().inverse();
}

struct Pixel {
    int x, y;
    float* rgba;
};

/// Smoke and fire, front to back; one for each thread.
template <class Marcher>
class RayFollower {
  public:
    RayFollower(const RenderVolume::Content& volume, const RenderOptions& options)
        : smoke_(volume, options), fire_(fireMarcher(volume, options)) {}

    RayState follow(const Ray& ray) {
        if (!fire_) return smoke_.follow(ray, nullptr);
        seen_.clear();
        RayState state = smoke_.follow(ray, &seen_);
        state.radiance += fire_->follow(ray, seen_);
        return state;
    }

  private:
    Marcher smoke_;
    std::unique_ptr<FireMarcher> fire_;
    TransmittanceAlongRay seen_;
};

template <class Marcher>
void renderPixel(Marcher& marcher, const PhotoCamera& camera, const RenderOptions& options, const Pixel& pixel) {
    Color radiance = grey(0);
    double transmittance = 0;
    const int n = options.samples;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const RayState state = marcher.follow(pixelRay(camera, pixel.x + (i + 0.5) / n, pixel.y + (j + 0.5) / n));
            radiance += state.radiance + options.background * float(state.transmittance);
            transmittance += state.transmittance;
        }
    const float share = 1 / float(n * n);
    for (int c = 0; c < 3; ++c) pixel.rgba[c] = radiance[c] * share;
    pixel.rgba[3] = float(1 - transmittance / (n * n));
}

/// @return false if stopped by `progress`.
template <class Marcher>
bool renderBuckets(const RenderVolume::Content& volume, const PhotoCamera& camera, const RenderOptions& options,
                   const ProgressCallback& progress, Image& image) {
    const int across = (image.width + kBucketSide - 1) / kBucketSide,
              down = (image.height + kBucketSide - 1) / kBucketSide;
    const std::size_t count = std::size_t(across) * down;
    const auto renderBucket = [&](std::size_t bucket) {
        RayFollower<Marcher> marcher(volume, options);
        const int x0 = int(bucket % across) * kBucketSide, y0 = int(bucket / across) * kBucketSide;
        for (int y = y0; y < std::min(y0 + kBucketSide, image.height); ++y)
            for (int x = x0; x < std::min(x0 + kBucketSide, image.width); ++x)
                renderPixel(marcher, camera, options, {x, y, image.at(x, y)});
    };
    for (std::size_t begin = 0; begin < count; begin += kBucketsPerGroup) {
        if (!report(progress, "render", double(begin) / double(count))) return false;
        parallelFor(std::min<std::size_t>(kBucketsPerGroup, count - begin),
                    [&](std::size_t i) { renderBucket(begin + i); });
    }
    report(progress, "render", 1);
    return true;
}

template <class RadiosityGrid, int kSharedChannels>
bool renderGrid(const RenderVolume::Content& volume, const PhotoCamera& camera, const RenderOptions& options,
                const ProgressCallback& progress, Image& image) {
    if (volume.smoke.blocks.channels == kSharedChannels)
        return renderBuckets<RayMarcher<RadiosityGrid, kSharedChannels>>(volume, camera, options, progress, image);
    return renderBuckets<RayMarcher<RadiosityGrid, 1>>(volume, camera, options, progress, image);
}

/// Exclusive at its upper end.
openvdb::CoordBBox boundsOf(const Int32Tree& occupied) {
    openvdb::CoordBBox bounds;
    occupied.evalActiveVoxelBoundingBox(bounds);
    if (!bounds.empty()) bounds.max().offset(1);
    return bounds;
}

/// Makes the blocks of emission.
void prepareFire(RenderVolume::Content& volume, const openvdb::GridBase::ConstPtr& emission) {
    withTypedGrid(*emission, [&](const auto& grid) {
        using Grid = std::decay_t<decltype(grid)>;
        const auto clean = zeroWhereInactive(openvdb::gridConstPtrCast<Grid>(emission));
        const Int32Tree::Ptr occupied = occupancy(*clean);
        volume.fire.indexFromWorld = indexFromWorld(grid);
        volume.fire.bounds = boundsOf(*occupied);
        volume.fire.blocks = makeBlocks(occupied, *clean);
        volume.emission = clean;
    });
    if (volume.fire.bounds.empty()) volume.emission = nullptr;
}

/// Makes the blocks of density and radiosity.
template <class RadiosityGrid>
void prepare(RenderVolume::Content& volume, const RadiosityGrid& radiosity) {
    volume.radiosityFromWorld = indexFromWorld(radiosity);
    const Int32Tree::Ptr occupied = occupancy(*volume.density);
    volume.smoke.bounds = boundsOf(*occupied);
    volume.smoke.blocks = radiosity.transform() == volume.density->transform()
                              ? makeBlocks(occupied, *volume.density, radiosity)
                              : makeBlocks(occupied, *volume.density);
}

}  // namespace

void RenderInput::validate() const {
    if (!density) throw InvalidArgument("render: no density grid is given");
    if (!radiosity) throw InvalidArgument("render: no radiosity grid is given; light the volume first");
    requireField(extinctionScale >= 0 && std::isfinite(extinctionScale), "extinctionScale", extinctionScale,
                 "finite and not negative");
    checkVoxels(*density, "density");
    requireLinear(*density, "density");
    const auto check = [](const openvdb::GridBase& some, const std::string& name, const char* kind) {
        withTypedGrid(some, [&](const auto& grid) { checkVoxels(grid, name); });
        requireLinear(some, kind);
    };
    check(*radiosity, radiosity->getName().empty() ? "radiosity" : radiosity->getName(), "radiosity");
    if (emission) check(*emission, "emission", "emission");
}

void RenderOptions::validate() const {
    requireField(step >= kShortestStep && step <= 8, "step", step, "between 0.01 and 8 voxels");
    requireField(samples >= 1 && samples <= 64, "samples", samples, "between 1 and 64 per side of a pixel");
    requireField(minTransmittance >= 0 && minTransmittance < 1, "minTransmittance", minTransmittance, "in [0,1)");
    for (int c = 0; c < 3; ++c)
        requireField(background[c] >= 0 && std::isfinite(background[c]), "background", background[c],
                     "finite and not negative");
}

RenderVolume::RenderVolume(const RenderInput& input) {
    input.validate();
    auto content = std::make_shared<Content>();
    content->density = zeroWhereInactive(input.density);
    content->radiosity = input.radiosity;
    content->extinctionScale = input.extinctionScale;
    content->smoke.indexFromWorld = indexFromWorld(*content->density);
    withTypedGrid(*input.radiosity, [&](const auto& radiosity) { prepare(*content, radiosity); });
    if (input.emission) prepareFire(*content, input.emission);
    content_ = std::move(content);
}

RenderResult render(const RenderVolume& volume, const Camera& camera, const RenderOptions& options,
                    const ProgressCallback& progress) {
    return render(volume, photoCamera(camera), options, progress);
}

RenderResult render(const RenderVolume& volume, const PhotoCamera& camera, const RenderOptions& options,
                    const ProgressCallback& progress) {
    const Timer timer;
    options.validate();
    camera.validate();
    const RenderVolume::Content& content = volume.content();
    RenderResult result;
    result.image = Image(camera.width, camera.height, 4);
    result.complete = content.radiosity->isType<FloatGrid>()
                          ? renderGrid<FloatGrid, 2>(content, camera, options, progress, result.image)
                          : renderGrid<Vec3SGrid, 4>(content, camera, options, progress, result.image);
    result.seconds = timer.seconds();
    return result;
}

RenderResult render(const RenderInput& input, const Camera& camera, const RenderOptions& options,
                    const ProgressCallback& progress) {
    const Timer timer;
    options.validate();
    RenderResult result = render(RenderVolume(input), camera, options, progress);
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

Box3 worldBounds(const RenderInput& input) {
    Box3 bounds = worldBounds(*input.density);
    if (input.emission) bounds.extendBy(worldBounds(*input.emission));
    return bounds;
}

}  // namespace raysweep
