// Time of a SART update: one view projected, compared and backprojected; and of what filtered backprojection does with
// a view. 256x256x110 voxels, views of 384x256 rays.
#include "raysweep/camera/projection_geometry.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/phantoms/solid_shapes.h"
#include "raysweep/reconstruct/fbp.h"
#include "raysweep/reconstruct/sart.h"

#include "triad.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <utility>

using namespace raysweep;

namespace {

const Index3 kDims(256, 256, 110);
constexpr double kBytesPerVoxel = 12;  // read to project; read and written to backproject

CircularOrbit orbitOf(BeamShape beam, int views) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.views = views;
    orbit.arc = beam == BeamShape::cone ? 360 : 180;
    orbit.width = 384;
    orbit.height = 256;
    orbit.sourceToAxis = 500;
    orbit.sourceToDetector = 750;
    orbit.pixelWidth = orbit.pixelHeight = beam == BeamShape::cone ? 1.5 : 1;
    return orbit;
}

/// Each detector turned about the middle of its plane.
ProjectionGeometry rolled(ProjectionGeometry geometry, double degrees) {
    const double c = std::cos(degrees * kPi / 180), s = std::sin(degrees * kPi / 180);
    for (XrayView& view : geometry.views) {
        const double x = 0.5 * (geometry.width - 1), y = 0.5 * (geometry.height - 1);
        const Vec3 middle = view.pixel(x, y), column = view.column;
        view.column = view.column * c + view.row * s;
        view.row = view.row * c - column * s;
        view.origin = middle - view.column * x - view.row * y;
    }
    return geometry;
}

ReconstructionGrid wholeGrid() {
    ReconstructionGrid grid;
    grid.dims = kDims;
    grid.spacing = Vec3(1);
    return grid;
}

/// A block that takes up `part` of the volume, seen along z.
Projections blockSeen(const ProjectionGeometry& geometry, double part) {
    const double half = 128 * std::sqrt(part);
    return exactProjections({box(0.01, Vec3(0), Vec3(half, half, 55))}, geometry);
}

/// 20 views around a block that takes up `part` of the volume.
void updates(benchmark::State& state, BeamShape beam, Support support, double part, double roll = 0) {
    CircularOrbit orbit = orbitOf(beam, 20);
    if (roll > 45) std::swap(orbit.width, orbit.height);  // on its side, for the same rays
    const ProjectionGeometry geometry = rolled(circularGeometry(orbit), roll);
    const Projections projections = blockSeen(geometry, part);
    SartOptions options;
    options.iterations = 1;
    options.lower = 0;
    options.support = support;
    const double voxels = double(kDims.x) * kDims.y * kDims.z;
    double seconds = 0, made = 0, kept = 0;
    for (auto _ : state) {
        const SartResult result = sart(projections, geometry, wholeGrid(), options);
        state.SetIterationTime(result.seconds);
        seconds += result.seconds;
        made += result.updates;
        kept = double(result.keptVoxels) / voxels;
    }
    const double perUpdate = seconds / made;
    state.counters["ms"] = 1e3 * perUpdate;
    state.counters["ns_voxel"] = 1e9 * perUpdate / voxels;
    state.counters["x_stream"] = perUpdate / (voxels * kBytesPerVoxel / triadBandwidth());
    state.counters["GB_s_triad"] = 1e-9 * triadBandwidth();
    state.counters["kept"] = kept;
}

/// FDK, all of it, by the number of views.
void filtered(benchmark::State& state, BeamShape beam) {
    constexpr int kViews = 120;
    const ProjectionGeometry geometry = circularGeometry(orbitOf(beam, kViews));
    const Projections projections = blockSeen(geometry, 1);
    double seconds = 0;
    int made = 0;
    for (auto _ : state) {
        const Timer timer;
        benchmark::DoNotOptimize(filteredBackprojection(projections, geometry, wholeGrid()));
        state.SetIterationTime(timer.seconds());
        seconds += timer.seconds();
        made += kViews;
    }
    state.counters["ms"] = 1e3 * seconds / made;
    state.counters["ns_voxel"] = 1e9 * seconds / made / (double(kDims.x) * kDims.y * kDims.z);
}

#define CT_BENCH(name, ...) BENCHMARK_CAPTURE(updates, name, __VA_ARGS__)->UseManualTime()->Iterations(3)

CT_BENCH(ct_parallel, BeamShape::parallel, Support::none, 1);
CT_BENCH(ct_cone, BeamShape::cone, Support::none, 1);
CT_BENCH(ct_half, BeamShape::parallel, Support::automatic, 0.5);
CT_BENCH(ct_half_cone, BeamShape::cone, Support::automatic, 0.5);
CT_BENCH(ct_rolled, BeamShape::cone, Support::none, 1, 1);
CT_BENCH(ct_rolled_more, BeamShape::cone, Support::none, 1, 3);
CT_BENCH(ct_on_side, BeamShape::cone, Support::none, 1, 90);
BENCHMARK_CAPTURE(filtered, ct_fdk, BeamShape::cone)->UseManualTime()->Iterations(3);

}  // namespace
