// Time of a SART update: one view projected, compared and backprojected; 256x256x110 voxels, views of 384x256 rays.
#include "raysweep/camera/projection_geometry.h"
#include "raysweep/phantoms/exact_projections.h"
#include "raysweep/phantoms/solid_shapes.h"
#include "raysweep/reconstruct/sart.h"

#include "triad.h"

#include <benchmark/benchmark.h>

#include <cmath>

using namespace raysweep;

namespace {

const Index3 kDims(256, 256, 110);
constexpr double kBytesPerVoxel = 12;  // read to project; read and written to backproject

/// 20 views around a block that takes up `part` of the volume, seen along z.
void updates(benchmark::State& state, BeamShape beam, Support support, double part) {
    CircularOrbit orbit;
    orbit.beam = beam;
    orbit.views = 20;
    orbit.arc = beam == BeamShape::cone ? 360 : 180;
    orbit.width = 384;
    orbit.height = 256;
    orbit.sourceToAxis = 500;
    orbit.sourceToDetector = 750;
    orbit.pixelWidth = orbit.pixelHeight = beam == BeamShape::cone ? 1.5 : 1;
    const ProjectionGeometry geometry = circularGeometry(orbit);
    const double half = 128 * std::sqrt(part);
    const Projections projections = exactProjections({box(0.01, Vec3(0), Vec3(half, half, 55))}, geometry);
    ReconstructionGrid grid;
    grid.dims = kDims;
    grid.spacing = 1;
    SartOptions options;
    options.iterations = 1;
    options.lower = 0;
    options.support = support;
    const double voxels = double(kDims.x) * kDims.y * kDims.z;
    double seconds = 0, made = 0, kept = 0;
    for (auto _ : state) {
        const SartResult result = sart(projections, geometry, grid, options);
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

#define CT_BENCH(name, ...) BENCHMARK_CAPTURE(updates, name, __VA_ARGS__)->UseManualTime()->Iterations(3)

CT_BENCH(ct_parallel, BeamShape::parallel, Support::none, 1);
CT_BENCH(ct_cone, BeamShape::cone, Support::none, 1);
CT_BENCH(ct_half, BeamShape::parallel, Support::automatic, 0.5);
CT_BENCH(ct_half_cone, BeamShape::cone, Support::automatic, 0.5);

}  // namespace
