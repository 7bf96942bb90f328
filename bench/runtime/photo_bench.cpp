// Photographs: time of a correction (photoSart) and of a sample of a fit's rays, there and back (compositeGradient).
// 128³ voxels of triangles, 20 pictures of 256².
#include "raysweep/core/parallel.h"
#include "raysweep/core/shuffle.h"
#include "raysweep/phantoms/triangles.h"
#include "raysweep/reconstruct/photo_pixels.h"
#include "raysweep/reconstruct/photo_sart.h"
#include "raysweep/render/rig.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

using namespace raysweep;

namespace {

constexpr int kEdge = 128;

ReconstructionGrid grid() {
    ReconstructionGrid grid;
    grid.dims = Index3(kEdge);
    grid.spacing = Vec3(2.0 / kEdge);
    return grid;
}

std::vector<Photograph> takePhotographs(Camera::Projection projection, RigOrbit orbit) {
    const ColorVolume triangles = makeTriangles({});
    RigOptions options;
    options.orbit = orbit;
    options.views = 20;
    options.projection = projection;
    return photographsOf({triangles.density, 1, triangles.color},
                         Rig{rigCameras(options, Box3(Vec3(-1), Vec3(1))), {}, {}});
}

void correction(benchmark::State& state, PhotoForm form, int threads) {
    static const std::vector<Photograph> photographs =
        takePhotographs(Camera::Projection::Orthographic, RigOrbit::ring);
    const ThreadLimit limit(threads);
    PhotoSartOptions options;
    options.form = form;
    options.iterations = 2;
    double seconds = 0, updates = 0, samples = 0;
    for (auto _ : state) {
        const PhotoReconstruction result = photoSart(photographs, grid(), options);
        state.SetIterationTime(result.timings.updates);
        seconds += result.timings.updates;
        updates += result.updates;
        samples += result.samples;
    }
    state.counters["ms"] = 1e3 * seconds / updates;
    state.counters["ns_sample"] = 1e9 * seconds / samples;
}

double bytesOf(const PhotoLevel& level) {
    const CompositeLayout& layout = level.layout;
    const double perBrick = sizeof(Index3) + 2 * sizeof(VoxelMask);
    return double(PhotoLevel::bytesPerVoxel(false)) * double(layout.voxelCount()) +
           perBrick * double(layout.brickCount()) +
           double(layout.table.size() * sizeof(layout.table[0]) + layout.cells.size());
}

/// Random pixels of all pictures, two samples a slice, in the haze that a fit begins with.
void samplesThereAndBack(benchmark::State& state) {
    constexpr std::size_t kRays = 16384;
    const std::vector<Photograph> photographs = takePhotographs(Camera::Projection::Perspective, RigOrbit::sphere);
    const ThreadLimit limit(1);
    PhotoLevel level = firstLevel(photographs, grid(), 0.02f, 0, false);
    const PhotoPixels pixels(photographs);
    std::vector<std::uint32_t> order = pixelsMeeting(pixels, level, {}).fitted;
    std::mt19937 random(1);
    shuffle(order, random);
    PhotoBatch batch;
    batch.set(pixels, order.data(), std::min(kRays, order.size()), level, 2);
    CompositeTape tape;
    double seconds = 0, samples = 0;
    const auto loss = [](std::size_t, std::size_t count, const RayColor* colors, RayColor* derivatives) {
        std::copy_n(colors, count, derivatives);
    };
    for (auto _ : state) {
        const Timer timer;
        compositeGradient(level.layout, level.voxels.data(), batch.rays, loss, tape, level.gradient.data());
        const double spent = timer.seconds();
        state.SetIterationTime(spent);
        seconds += spent;
        samples += double(tape.samples);
    }
    state.counters["ns_sample"] = 1e9 * seconds / samples;
    state.counters["bytes_voxel"] = bytesOf(level) / double(level.layout.keptVoxels());
}

#define PHOTO_BENCH(name, ...) BENCHMARK_CAPTURE(correction, name, __VA_ARGS__)->UseManualTime()->Iterations(2)

PHOTO_BENCH(photo_consistent, PhotoForm::consistent, 2);
PHOTO_BENCH(photo_consistent_1thread, PhotoForm::consistent, 1);
PHOTO_BENCH(photo_paper, PhotoForm::paper, 2);

BENCHMARK(samplesThereAndBack)->Name("samples/photo_fit_1thread")->UseManualTime()->Iterations(20);

}  // namespace
