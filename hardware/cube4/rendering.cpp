#include "cube4/rendering.h"

#include "cube4/arithmetic.h"
#include "cube4/base_plane.h"
#include "cube4/cone_warp.h"
#include "cube4/region_bound.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>

namespace raysweep::cube4 {
namespace {

constexpr int kTableBits = 12;  ///< of a scalar that address the table, at most: VolumePro's 4096 entries

/// One wavelength in the machine.
template <class Arithmetic>
class Machine {
  public:
    using Word = typename Arithmetic::Word;

    Machine(const LitVolume& volume, const Vec3& direction, const RenderSetup& setup, Arithmetic arithmetic)
        : volume_(volume),
          direction_(direction),
          setup_(setup),
          arithmetic_(std::move(arithmetic)),
          pad_(setup.lambert ? 2 : 1),
          memory_(volume.box.size() + Index3(2 * pad_), setup.pipelines) {
        if constexpr (!Arithmetic::kExact) {
            const NumberFormat& format = arithmetic_.format();
            const auto unitOf = [](double most, int bits) {
                return most > 0 ? most / (std::ldexp(1.0, bits) - 1) : 1.0;
            };
            double brightest = 0;
            for (const DenseField& field : volume.radiosity) brightest = std::max(brightest, largestOf(field));
            scalarUnit_ = unitOf(largestOf(volume.extinction), format.scalar);
            radianceUnit_ = unitOf(brightest, format.energy);
        }
        memory_.forEachWithin(pad_, [&](std::size_t i, Voxel<Word>& voxel) {
            voxel.scalar = Arithmetic::word(double(volume.extinction[i]), scalarUnit_);
        });
    }

    void load(const DenseField& radiosity) {
        memory_.forEachWithin(pad_, [&](std::size_t i, Voxel<Word>& voxel) {
            voxel.source = Arithmetic::word(double(radiosity[i]), radianceUnit_);
        });
    }

    /// C and T of the base plane.
    PassResult<Word> run(const Traversal& traversal) {
        const bool inSlices = setup_.depth == 0;
        const auto slices = renderSlices(traversal, arithmetic_, renderDelay(inSlices, setup_.lambert));
        const ShadeSetup<Word> shade = shadeSetup(traversal);
        Between<typename Arithmetic::Weight> between;
        between.high = arithmetic_.weight(setup_.depth);
        between.low = arithmetic_.weight(1) - between.high;
        return runRender(arithmetic_, memory_, {traversal, slices, shade, between, inSlices}, setup_.pipelines,
                         setup_.trace);
    }

    /// C and T after a pass over a region.
    PassResult<Word> run(const RegionPass<typename Arithmetic::Weight>& pass, const PerspectiveFront& front,
                         const RayPlane<Word>& entering) {
        const Traversal& traversal = pass.traversal;
        const Matrix3& world = volume_.box.worldFromIndex;
        const double longest = front.longest(world);
        ShadeSetup<Word> shade;
        shade.depth = longest * scalarUnit_;
        shade.reach = traversal.reach;
        Matrix3 ways;  // a voxel along u, v and k, of the longest way
        const int axes[3] = {traversal.axisU, traversal.axisV, traversal.major};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) ways[i][j] = world[axes[i]][j] / longest;
        shade.lengths = ways * ways.transposed();
        tabulate(shade);
        return runRender(arithmetic_, memory_, {traversal, pass.slices, shade, {}, true, &entering}, setup_.pipelines,
                         setup_.trace);
    }

    Traversal traversalOf(const BasePlane& plane) const {
        const Index3 size = memory_.size();
        Traversal traversal = traverse(size, {Index3(0), size}, plane.direction(), Resampling::linear);
        traversal.reach = pad_;
        return traversal;
    }
    int pad() const { return pad_; }
    double radianceOf(Word word) const { return double(word) * radianceUnit_; }
    double transmittanceOf(Word word) const { return double(word) / double(arithmetic_.one()); }

    /// Extinction and radiance.
    std::size_t bytesPerModule() const {
        const std::size_t bits =
            setup_.format ? std::size_t(setup_.format->scalar + setup_.format->energy) : 2 * 8 * sizeof(Word);
        return (memory_.voxelsPerModule() * bits + 7) / 8;
    }

  private:
    ShadeSetup<Word> shadeSetup(const Traversal& traversal) const {
        ShadeSetup<Word> setup;
        setup.depth = traversal.stepLength * scalarUnit_;
        setup.lambert = setup_.lambert;
        // Gradients along u, v, k are those along the memory's axes, in the order and sense of the pass.
        Matrix3 pass;
        const int axes[3] = {traversal.axisU, traversal.axisV, traversal.major};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) pass[i][j] = axes[i] == j ? (traversal.descending ? -1 : 1) : 0;
        const Matrix3 memoryFromWorld = volume_.box.worldFromIndex.inverse();
        const Matrix3 worldGradient = pass * memoryFromWorld.transposed();
        setup.metric = worldGradient * worldGradient.transposed();
        setup.view = direction_ * worldGradient.transposed();
        tabulate(setup);
        return setup;
    }

    /// Fixed point: opacities by scalars.
    void tabulate(ShadeSetup<Word>& setup) const {
        if constexpr (!Arithmetic::kExact) {
            const int bits = arithmetic_.format().scalar;
            setup.tableShift = std::max(0, bits - kTableBits);
            for (std::size_t entry = 0; entry < std::size_t(1) << (bits - setup.tableShift); ++entry) {
                const double scalar = double(entry << setup.tableShift) + 0.5 * (std::ldexp(1.0, setup.tableShift) - 1);
                setup.opacity.push_back(
                    Word(std::llround(-std::expm1(-scalar * setup.depth) * double(arithmetic_.one()))));
            }
        } else {
            (void)setup;
        }
    }

    const LitVolume& volume_;
    const Vec3 direction_;  ///< of sight, world, unit
    RenderSetup setup_;
    Arithmetic arithmetic_;
    int pad_;
    double scalarUnit_ = 1, radianceUnit_ = 1;
    VoxelMemory<Word> memory_;
};

template <class Arithmetic>
Rendering renderWith(const LitVolume& volume, const ParallelView& view, const RenderSetup& setup,
                     Arithmetic arithmetic) {
    Machine<Arithmetic> machine(volume, view.direction.normalized(), setup, std::move(arithmetic));
    const Index3 memory = volume.box.size() + Index3(2 * machine.pad());
    const BasePlane plane({view.direction, view.origin, view.column, view.row}, volume.box, volume.origin,
                          machine.pad(), {Index3(0), memory}, setup.depth);
    const Traversal traversal = machine.traversalOf(plane);
    Rendering rendering;
    rendering.image = Image(view.width, view.height, 4);
    rendering.step = traversal.stepLength;
    rendering.bytesPerModule = machine.bytesPerModule();
    rendering.passes = volume.radiosity.size();
    rendering.voxels = volume.box.voxels();
    for (std::size_t c = 0; c < volume.radiosity.size(); ++c) {
        machine.load(volume.radiosity[c]);
        const auto result = machine.run(traversal);
        rendering.counters += result.counters;
        const std::size_t bits = setup.format ? std::size_t(setup.format->energy) : 32;
        rendering.bufferBytes = ((result.rayWords + result.bufferWords) * bits + 7) / 8;
        std::vector<float> color, through;
        for (const auto& ray : result.leaving.rays) {
            color.push_back(float(machine.radianceOf(ray.value)));
            through.push_back(float(machine.transmittanceOf(ray.weight)));
        }
        const LatticeShift u = latticeShift(traversal, 0, 0), v = latticeShift(traversal, 1, 0);
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                // Samples are `depth` behind slices, straight below the lattice's points in them.
                const Imath::V2d position = plane.positionOf(traversal, x, y, setup.depth);
                const Imath::V2d at(snapped(position.x - u.shift - u.fraction - result.leaving.lowU),
                                    snapped(position.y - v.shift - v.fraction - result.leaving.lowV));
                float C = sampleOf(color, result.leaving.width, result.leaving.height, at);
                float T = sampleOf(through, result.leaving.width, result.leaving.height, at);
                if (std::isnan(C) || std::isnan(T)) C = 0, T = 1;
                float* const pixel = rendering.image.at(x, y);
                for (std::size_t channel = c; channel < (volume.radiosity.size() == 1 ? 3 : c + 1); ++channel)
                    pixel[channel] = C + T * float(setup.background);
                pixel[3] = 1 - T;
            }
    }
    return rendering;
}

/// A plane of rays as the picture takes it: what is seen along each ray, background and all, and T.
template <class Arithmetic>
struct Seen {
    RayPlane<float> rays;

    Seen(const Machine<Arithmetic>& machine, const RayPlane<typename Arithmetic::Word>& plane, double background) {
        rays.lowU = plane.lowU, rays.lowV = plane.lowV, rays.width = plane.width, rays.height = plane.height;
        for (const auto& ray : plane.rays) {
            const double T = machine.transmittanceOf(ray.weight);
            rays.rays.push_back({float(machine.radianceOf(ray.value) + T * background), float(T)});
        }
    }
};

/// Puts what a front's rays carry into the pixels that are its own.
void warp(Image& image, const RayPlane<float>& seen, const Imath::V2d& ray, std::size_t pixel,
          const std::pair<std::size_t, std::size_t>& channels) {
    const LatticePoint point(seen, ray);
    if (point.isOutside()) return;
    float* const to = image.at(int(pixel % std::size_t(image.width)), int(pixel / std::size_t(image.width)));
    for (std::size_t channel = channels.first; channel < channels.second; ++channel)
        to[channel] = float(point.interpolated(seen.rays, [](const Ray<float>& seenRay) { return seenRay.value; }));
    to[3] = 1 - float(point.interpolated(seen.rays, [](const Ray<float>& seenRay) { return seenRay.weight; }));
}

template <class Arithmetic>
Rendering renderFrom(const LitVolume& volume, const PointRays& view, const RenderSetup& setup, Arithmetic arithmetic) {
    using Word = typename Arithmetic::Word;
    Machine<Arithmetic> machine(volume, Vec3(0), setup, arithmetic);
    const MemoryBox memory{volume.box, volume.origin, machine.pad()};
    const std::vector<PerspectiveFront> fronts = frontsOf(view, memory, setup.sampling);
    Rendering rendering;
    rendering.image = Image(view.width, view.height, 4);
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) std::fill_n(rendering.image.at(x, y), 3, float(setup.background));
    rendering.bytesPerModule = machine.bytesPerModule();
    rendering.passes = volume.radiosity.size();
    rendering.voxels = volume.box.voxels();
    const Ray<Word> empty{Word{}, arithmetic.one()};
    const std::size_t bits = setup.format ? std::size_t(setup.format->energy) : 32;
    for (std::size_t c = 0; c < volume.radiosity.size(); ++c) {
        machine.load(volume.radiosity[c]);
        for (const PerspectiveFront& front : fronts) {
            const RayPlane<Word> rays =
                passRegions(RegionBound<Arithmetic>(arithmetic, setup.pipelines, rendering.counters, empty),
                            {front, memory, RayOrder::diverging, 0},
                            planeOf<Word>(front.rangeAt(front.regions.front().level), empty),
                            [&](const RegionPass<typename Arithmetic::Weight>& pass, const RayPlane<Word>& entering) {
                                auto result = machine.run(pass, front, entering);
                                rendering.counters += result.counters;
                                rendering.bufferBytes = std::max(
                                    rendering.bufferBytes, ((result.rayWords + result.bufferWords) * bits + 7) / 8);
                                return std::move(result.leaving);
                            });
            const Seen<Arithmetic> seen(machine, rays, setup.background);
            forEachPixel(view, memory, front, [&](std::size_t pixel, const Imath::V2d& ray, double) {
                warp(rendering.image, seen.rays, ray, pixel, {c, volume.radiosity.size() == 1 ? 3 : c + 1});
            });
            rendering.step = front.lengthOf(front.wayOf(0, 0, 0), volume.box.worldFromIndex);
        }
    }
    return rendering;
}

}  // namespace

void RenderSetup::validate() const {
    requireField(pipelines >= 1, "pipelines", pipelines, "at least 1");
    requireField(depth >= 0 && depth < 1, "depth", depth, "in [0,1)");
    sampling.validate();
    requireField(background >= 0 && std::isfinite(background), "background", background, "0 or more, and finite");
    if (format) format->validate();
}

Rendering renderView(const LitVolume& volume, const ParallelView& view, const RenderSetup& setup) {
    setup.validate();
    if (setup.format) return renderWith(volume, view, setup, FixedPoint(*setup.format));
    return renderWith(volume, view, setup, FloatArithmetic());
}

Rendering renderView(const LitVolume& volume, const PointRays& view, const RenderSetup& setup) {
    setup.validate();
    if (setup.lambert) throw InvalidArgument("shading by gradients needs parallel rays; these come from an eye");
    if (setup.depth > 0) throw InvalidArgument("samples of rays that come from an eye are in slices: their depth is 0");
    if (setup.format) return renderFrom(volume, view, setup, FixedPoint(*setup.format));
    return renderFrom(volume, view, setup, FloatArithmetic());
}

PointRays viewFrom(const Vec3& eye, const Vec3& direction, const Vec3& up, double fov, const Imath::V2i& pixels) {
    const Vec3 forward = direction.normalized(), right = forward.cross(up), below = forward.cross(right);
    if (!(direction.length() > 0)) throw InvalidArgument("a view's direction must have a length");
    if (!(right.length() > 1e-6 * up.length())) throw InvalidArgument("a view's `up` must not be along its direction");
    requireField(fov > 0 && fov < 180, "fov", fov, "in (0,180)");
    PointRays view;
    view.source = eye;
    view.width = pixels.x;
    view.height = pixels.y;
    const double pixel = 2 * std::tan(fov * M_PI / 360) / view.height;
    view.column = right.normalized() * pixel;
    view.row = below.normalized() * pixel;
    view.origin = eye + forward - view.column * (0.5 * (view.width - 1)) - view.row * (0.5 * (view.height - 1));
    return view;
}

ParallelView viewOf(const LitVolume& volume, const Vec3& direction, const Vec3& up, int width, int height) {
    ParallelView view;
    if (!(direction.length() > 0)) throw InvalidArgument("a view's direction must have a length");
    view.direction = direction.normalized();
    const Vec3 right = view.direction.cross(up), below = view.direction.cross(right);
    if (!(right.length() > 1e-6 * up.length())) throw InvalidArgument("a view's `up` must not be along its direction");
    const Index3 size = volume.box.size();
    const Matrix3& m = volume.box.worldFromIndex;
    const Vec3 center = volume.origin + Vec3(0.5 * (size.x - 1), 0.5 * (size.y - 1), 0.5 * (size.z - 1)) * m;
    double halfWidth = 0, halfHeight = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 from =
            Vec3(corner & 1 ? size.x : -size.x, corner & 2 ? size.y : -size.y, corner & 4 ? size.z : -size.z) * 0.5 * m;
        halfWidth = std::max(halfWidth, std::abs(from.dot(right.normalized())));
        halfHeight = std::max(halfHeight, std::abs(from.dot(below.normalized())));
    }
    view.width = width;
    view.height = height;
    const double pixel = std::max(2 * halfWidth / width, 2 * halfHeight / height);
    view.column = right.normalized() * pixel;
    view.row = below.normalized() * pixel;
    view.origin = center - view.column * (0.5 * (width - 1)) - view.row * (0.5 * (height - 1));
    return view;
}

}  // namespace raysweep::cube4
