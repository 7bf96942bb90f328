// Time of pictures: of making a volume ready, and of a ray.
#include "raysweep/core/parallel.h"
#include "raysweep/core/progress.h"
#include "raysweep/phantoms/phantom.h"
#include "raysweep/render/render.h"

#include <benchmark/benchmark.h>

using namespace raysweep;

namespace {

/// A cloud of one brightness.
RenderInput cloud(bool coloured) {
    PhantomOptions options;
    options.size = 300;
    RenderInput input;
    const auto density = makeCloud(options);
    input.density = density;
    input.extinctionScale = 40;
    if (coloured) {
        auto radiosity = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0f));
        radiosity->setTransform(density->transform().copy());
        radiosity->topologyUnion(*density);
        for (auto on = radiosity->beginValueOn(); on; ++on) on.setValue(openvdb::Vec3s(1, 0.9f, 0.8f));
        input.radiosity = radiosity;
    } else {
        const auto radiosity = density->deepCopy();
        for (auto on = radiosity->beginValueOn(); on; ++on) on.setValue(1.0f);
        input.radiosity = radiosity;
    }
    return input;
}

void prepareBench(benchmark::State& bench) {
    const RenderInput input = cloud(false);
    for (auto _ : bench) benchmark::DoNotOptimize(RenderVolume(input));
}

void renderBench(benchmark::State& bench, bool coloured, int threads) {
    const RenderInput input = cloud(coloured);
    const RenderVolume volume(input);
    Camera camera;
    camera.width = camera.height = 512;
    camera = framed(camera, worldBounds(*input.density));
    const ThreadLimit limit(threads);
    double seconds = 0;
    for (auto _ : bench) seconds += render(volume, camera).seconds;
    bench.counters["ns_ray"] = 1e9 * seconds / double(bench.iterations()) / (512.0 * 512.0);
}

BENCHMARK(prepareBench)->Name("render_prepare")->UseRealTime()->Unit(benchmark::kMillisecond);
#define RENDER_BENCH(name, ...) \
    BENCHMARK_CAPTURE(renderBench, name, __VA_ARGS__)->UseRealTime()->Unit(benchmark::kMillisecond)
RENDER_BENCH(cloud, false, 2);
RENDER_BENCH(cloud_1thread, false, 1);
RENDER_BENCH(cloud_colour, true, 2);

}  // namespace
