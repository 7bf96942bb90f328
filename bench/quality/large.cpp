// Time and memory of sweeps in a large volume, per active voxel. One volume per run, so that its memory is its own.
#include "raysweep/core/memory.h"
#include "raysweep/illuminate/illuminate.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/vdb_io.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>

using namespace raysweep;

namespace {

constexpr double kOpticalDepth = 0.1;  ///< of a voxel of density 1
/// Sweeps before the clock starts: the first ones touch memory that the system has yet to provide.
constexpr int kUntimed = 32;

Scene sceneOf(const openvdb::FloatGrid::Ptr& density) {
    Scene scene;
    scene.medium.density = density;
    scene.medium.extinctionScale = kOpticalDepth / density->voxelSize()[0];
    scene.suns.push_back({Vec3(0.3, 0.5, -1), grey(3)});
    scene.sky.radiance = grey(0.3f);
    return scene;
}

double secondsPerSweep(const Scene& scene, int sweeps) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = kUntimed + sweeps;
    options.remaining = Remaining::drop;  // finishing sweeps are sweeps like others
    options.beams = 4;
    Timer timer;
    int done = 0;
    double seconds = 0;
    options.afterSweep = [&](const Vec3&, const RaySums&) {
        ++done;
        if (done == kUntimed) timer = Timer();
        if (done == options.sweeps) seconds = timer.seconds();
    };
    illuminate(scene, options);
    return seconds / sweeps;
}

void measure(const std::string& path, int sweeps) {
    const std::size_t before = residentBytes();
    const openvdb::FloatGrid::Ptr density = selectDensity(readVdb(path));
    const double seconds = secondsPerSweep(sceneOf(density), sweeps);
    const std::size_t peak = peakResidentBytes();

    const auto voxels = double(density->activeVoxelCount());
    const openvdb::Coord box = density->evalActiveVoxelDim();
    const double edge = std::max({box.x(), box.y(), box.z()}), bricks = double(density->tree().leafCount());
    std::printf(
        "edge,voxels,share_of_cube,share_of_bricks,seconds_per_sweep,ns_per_voxel,bytes_per_voxel,peak_bytes\n");
    std::printf("%g,%.0f,%.4f,%.4f,%.6g,%.4f,%.2f,%zu\n", edge, voxels, voxels / (edge * edge * edge),
                voxels / (512 * bricks), seconds, 1e9 * seconds / voxels, double(peak - before) / voxels, peak);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Seconds per sweep and bytes, the input included, per active voxel");
    std::string file;
    int sweeps = 32;
    app.add_option("file", file, "Fog volume without tiles")->required();
    app.add_option("--sweeps", sweeps, "That are timed")->check(CLI::PositiveNumber)->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try {
        measure(file, sweeps);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "raysweep_large: %s\n", e.what());
        return 1;
    }
}
