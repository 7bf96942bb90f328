// Time of a sweep against the time that streaming the same voxels through memory takes, measured in the same run:
// machines differ and are shared, ratios stay.
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/direct.h"
#include "raysweep/illuminate/state.h"
#include "raysweep/sweep/directions.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/vdb_io.h"

#include "support/volumes.h"
#include "triad.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <vector>

using namespace raysweep;

namespace {

constexpr double kBytesPerVoxel = 20;  // extinction, unshot and deposit read, unshot and deposit written

openvdb::FloatGrid::Ptr denseBlock(int x, int y, int z) {
    auto grid = openvdb::FloatGrid::create();
    grid->denseFill({{0, 0, 0}, {x - 1, y - 1, z - 1}}, 0.02f);
    return grid;
}

openvdb::FloatGrid::Ptr smoke() {
    const std::string path = test::findData("vdb/smoke.vdb");
    return path.empty() ? nullptr : selectDensity(readVdb(path));
}

/// Smoke with two more voxels, so far away that the bounding box is ten times as long along every axis.
openvdb::FloatGrid::Ptr smokeInLargeBox() {
    const auto grid = smoke();
    if (!grid) return grid;
    const auto wide = grid->deepCopy();
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    const openvdb::Coord size = box.dim();
    const auto shifted = [&](const openvdb::Coord& from, double times) {
        return openvdb::Coord(from.x() + int(times * size.x()), from.y() + int(times * size.y()),
                              from.z() + int(times * size.z()));
    };
    wide->tree().setValue(shifted(box.min(), -4.5), 0.1f);
    wide->tree().setValue(shifted(box.max(), 4.5), 0.1f);
    return wide;
}

/// A state as in the middle of a solution: everything has been touched.
std::unique_ptr<SolverState> makeState(const openvdb::FloatGrid::Ptr& density, double extinction,
                                       Interpolation interpolation, bool coloured, Exchange exchange) {
    Scene scene;
    scene.medium.density = density;
    scene.medium.extinctionScale = extinction;
    if (coloured) scene.medium.albedo = Color(0.9f, 0.8f, 0.7f);
    scene.sky.radiance = grey(1);
    IlluminateOptions options;
    options.interpolation = interpolation;
    options.exchange = exchange;
    auto state = std::make_unique<SolverState>(prepareState(scene, options, planIllumination(scene, options)));
    allocateSweepFields(*state, options);
    return state;
}

using Volume = openvdb::FloatGrid::Ptr (*)();
openvdb::FloatGrid::Ptr paperBlock() {
    return denseBlock(276, 276, 130);
}
/// Walls, eight voxels thick, with as much room between them: every brick has surfaces or the inside of a solid.
openvdb::FloatGrid::Ptr walledBlock() {
    const auto grid = paperBlock();
    for (int x = 4; x < 276; x += 16) grid->denseFill({{x, 0, 0}, {std::min(x + 7, 275), 275, 129}}, 1.0f);
    return grid;
}
openvdb::FloatGrid::Ptr cachedBlock() {
    return denseBlock(40, 40, 40);
}  // its fields fit a core's own cache

/// `major` in 0..2 takes directions of that axis only, 3 all.
void sweepBench(benchmark::State& bench, Volume volume, Interpolation interpolation, bool coloured, int threads,
                int major, int beamCount = 4, Exchange exchange = Exchange::medium) {
    const openvdb::FloatGrid::Ptr density = volume();
    if (!density) return bench.SkipWithError("the smoke volume is not there");
    const auto state = makeState(density, 1.0, interpolation, coloured, exchange);
    const ExchangeFields fields = exchangeFields(*state, /*injecting=*/true);
    DirectionSequence directions({DirectionSet::fibonacci, 96, 1, beamCount}, directionClass);
    const auto sweepOnce = [&] {
        std::vector<Beam> beams;
        do {
            beams.clear();
            for (const Vec3& direction : directions.nextGroup(beamCount)) {
                const int reach = interpolation == Interpolation::linear ? 1 : 0;
                beams.push_back(darkBeam(state->medium, parallelFront(state->medium.volume.layout, direction, reach,
                                                                      {0.3, 0.7}, state->medium.volume.periodic)));
                for (float& power : beams.back().entering) power = 1;
            }
        } while (int(beams.size()) < beamCount || (major < 3 && beams[0].front.axis.major != major));
        const ExchangeConstants constants = exchangeConstants(*state, 0.1 / beamCount, beamCount);
        benchmark::DoNotOptimize(sweep(state->medium.volume, beams, interpolation, fields, constants));
        if (interpolation == Interpolation::linear) settle(state->medium.volume, beams, fields, constants);
    };
    const double streaming = double(state->medium.volume.layout.activeVoxels) * kBytesPerVoxel / triadBandwidth();
    const ThreadLimit limit(threads);
    for (int i = 0; i < 8; ++i) sweepOnce();
    double seconds = 0;
    for (auto _ : bench) {
        const Timer timer;
        sweepOnce();
        seconds += timer.seconds();
    }
    const double perSweep = seconds / double(bench.iterations()) / beamCount;
    bench.counters["ms"] = 1e3 * perSweep;
    bench.counters["ns_voxel"] = 1e9 * perSweep / double(state->medium.volume.layout.activeVoxels);
    bench.counters["x_stream"] = perSweep / streaming;
    bench.counters["GB_s_triad"] = 1e-9 * triadBandwidth();
}

#define SWEEP_BENCH(name, ...) BENCHMARK_CAPTURE(sweepBench, name, __VA_ARGS__)->UseRealTime()->Iterations(24)

SWEEP_BENCH(dense_nearest, paperBlock, Interpolation::nearest, false, 2, 3);
SWEEP_BENCH(dense_nearest_1beam, paperBlock, Interpolation::nearest, false, 2, 3, 1);
SWEEP_BENCH(dense_nearest_2beams, paperBlock, Interpolation::nearest, false, 2, 3, 2);
SWEEP_BENCH(dense_nearest_8beams, paperBlock, Interpolation::nearest, false, 2, 3, 8);
SWEEP_BENCH(dense_nearest_x, paperBlock, Interpolation::nearest, false, 2, 0);
SWEEP_BENCH(dense_nearest_y, paperBlock, Interpolation::nearest, false, 2, 1);
SWEEP_BENCH(dense_nearest_z, paperBlock, Interpolation::nearest, false, 2, 2);
SWEEP_BENCH(dense_nearest_1thread, paperBlock, Interpolation::nearest, false, 1, 3);
SWEEP_BENCH(cached_nearest_1thread, cachedBlock, Interpolation::nearest, false, 1, 3);
SWEEP_BENCH(dense_linear, paperBlock, Interpolation::linear, false, 2, 3);
SWEEP_BENCH(dense_surfaces, walledBlock, Interpolation::nearest, false, 2, 3, 4, Exchange::surface);
SWEEP_BENCH(dense_colour, paperBlock, Interpolation::nearest, true, 2, 3);
SWEEP_BENCH(smoke_nearest, smoke, Interpolation::nearest, false, 2, 3);
SWEEP_BENCH(smoke_nearest_1thread, smoke, Interpolation::nearest, false, 1, 3);
SWEEP_BENCH(smoke_linear, smoke, Interpolation::linear, false, 2, 3);
SWEEP_BENCH(smoke_colour, smoke, Interpolation::nearest, true, 2, 3);
SWEEP_BENCH(smoke_in_large_box, smokeInLargeBox, Interpolation::nearest, false, 2, 3);

}  // namespace

BENCHMARK_MAIN();
