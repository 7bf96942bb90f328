// The Cube-4 emulator: time of a sweep by one core, in floats and in words of 16 bits.
#include "cube4/illumination.h"

#include <benchmark/benchmark.h>

#include <chrono>
#include <optional>
#include <random>

using namespace raysweep::cube4;

namespace {

DenseMedium cube(int edge) {
    DenseMedium medium;
    medium.box.high = raysweep::Index3(edge);
    medium.box.worldFromIndex.makeIdentity();
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 0.2f);
    for (std::size_t i = 0; i < medium.box.voxels(); ++i) medium.extinction.push_back(uniform(random));
    medium.albedo.assign(medium.extinction.size(), 0.9f);
    medium.source.assign(medium.extinction.size(), 0.01f);
    return medium;
}

void sweep(benchmark::State& state, int edge, int pipelines, bool fixed) {
    IlluminationSetup setup;
    setup.pipelines = pipelines;
    if (fixed) setup.format = NumberFormat{};
    setup.largestPower = 10;
    Illumination machine(cube(edge), setup);
    double seconds = 0, voxelCycles = 0;
    for (auto _ : state) {
        const auto from = std::chrono::steady_clock::now();
        const std::uint64_t before = machine.counters().cycles;
        machine.sweep({{{0.5, -0.3, 0.8}, 0.3, 0.6, 0.1}}, true);
        const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
        state.SetIterationTime(took);
        seconds += took;
        voxelCycles += double(machine.counters().cycles - before) * pipelines;
    }
    state.counters["ms"] = 1e3 * seconds / double(state.iterations());
    state.counters["ns_voxel"] = 1e9 * seconds / voxelCycles;
}

#define CUBE4_BENCH(name, ...) \
    BENCHMARK_CAPTURE(sweep, name, __VA_ARGS__)->UseManualTime()->Iterations(8)->Unit(benchmark::kMillisecond)

CUBE4_BENCH(cube4_64, 64, 16, false);
CUBE4_BENCH(cube4_64_one, 64, 1, false);
CUBE4_BENCH(cube4_64_fixed, 64, 16, true);
CUBE4_BENCH(cube4_128, 128, 16, false);

}  // namespace
