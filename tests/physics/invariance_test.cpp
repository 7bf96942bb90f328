// What must not change the answer: threads, how a grid stores its voxels, the run, the orientation, the interpolation.
#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/illuminate.h"
#include "support/blocks.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

Scene cloudScene(bool coloured) {
    Scene scene;
    scene.medium.density = cloudVolume(40);
    scene.medium.extinctionScale = 0.2;
    scene.medium.albedo = coloured ? Color(0.9f, 0.95f, 0.99f) : grey(0.95f);
    scene.suns.push_back({Vec3(0.3, 0.2, -1), grey(2)});
    scene.points.push_back({Vec3(10, 11, 9), grey(300)});
    scene.sky.radiance = grey(0.3f);
    return scene;
}

IlluminateOptions fixedSweeps(int sweeps) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = sweeps;
    return options;
}

void expectSameBits(const Illumination& a, const Illumination& b) {
    EXPECT_TRUE(sameBits(*a.radiosity, *b.radiosity));
    EXPECT_TRUE(sameBits(*a.unshot, *b.unshot));
    EXPECT_EQ(a.finishingSweeps, b.finishingSweeps);
    EXPECT_EQ(a.power.absorbed[0], b.power.absorbed[0]);
    EXPECT_EQ(a.power.escaped[0], b.power.escaped[0]);
}

/// Block averages of 4^3 voxels differ by this much.
double blockDifference(const openvdb::FloatGrid& density, const openvdb::GridBase& a, const openvdb::GridBase& b) {
    const DenseVolume weights = dense(density, density);
    return blockError(dense(a, density, 0).values, dense(b, density, 0).values, weights.values, weights.size);
}

}  // namespace

TEST(Invariance, OfTheNumberOfThreads) {
    for (const bool coloured : {false, true})
        for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear}) {
            IlluminateOptions options = fixedSweeps(60);
            options.interpolation = interpolation;
            const Scene scene = cloudScene(coloured);
            const auto withThreads = [&](int threads) {
                const ThreadLimit limit(threads);
                return illuminate(scene, options);
            };
            const Illumination one = withThreads(1);
            expectSameBits(one, withThreads(2));
            expectSameBits(one, withThreads(7));
        }
}

TEST(Invariance, OfThreadsWhereCellsOfTheWavefrontMeet) {
    // Wide enough for several cells of the wavefront side by side.
    Scene scene;
    scene.medium.density = boxVolume({304, 296, 16});
    scene.medium.extinctionScale = 0.05;
    scene.sky.radiance = grey(1);
    for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear}) {
        IlluminateOptions options = fixedSweeps(20);
        options.remaining = Remaining::drop;
        options.interpolation = interpolation;
        const auto withThreads = [&](int threads) {
            const ThreadLimit limit(threads);
            return illuminate(scene, options);
        };
        expectSameBits(withThreads(1), withThreads(2));
    }
}

TEST(Invariance, OfTheRun) {
    const Scene scene = cloudScene(false);
    IlluminateOptions options = fixedSweeps(40);
    const Illumination first = illuminate(scene, options);
    expectSameBits(first, illuminate(scene, options));
    options.seed = 2;
    EXPECT_FALSE(sameBits(*first.radiosity, *illuminate(scene, options).radiosity)) << "the seed has no effect";
}

TEST(Invariance, OfTilesAndVoxels) {
    auto tiles = openvdb::FloatGrid::create();
    tiles->fill({{0, 0, 0}, {31, 23, 15}}, 0.7f);
    tiles->fill({{-128, -128, -128}, {-1, -1, -1}}, 0.002f);  // a tile of 128^3
    tiles->tree().setValue({40, 3, 3}, 2);
    ASSERT_GT(tiles->tree().activeTileCount(), 1u);
    auto voxels = tiles->deepCopy();
    voxels->tree().voxelizeActiveTiles();
    ASSERT_EQ(voxels->tree().activeTileCount(), 0u);
    Scene scene;
    scene.suns.push_back({Vec3(0.3, 0.2, -1), grey(2)});
    scene.sky.radiance = grey(0.3f);
    IlluminateOptions options = fixedSweeps(20);
    scene.medium.density = tiles;
    const Illumination ofTiles = illuminate(scene, options);
    scene.medium.density = voxels;
    expectSameBits(ofTiles, illuminate(scene, options));
}

// A turned scene is lit by the same directions, unturned, so answers differ by the noise of directions and of ray
// lattices: that of two seeds.
TEST(InvarianceSlow, OfQuarterTurns) {
    const Scene scene = cloudScene(false);
    IlluminateOptions options = fixedSweeps(512);
    const Illumination straight = illuminate(scene, options);
    options.seed = 2;
    const double noise =
        blockDifference(*scene.medium.density, *illuminate(scene, options).radiosity, *straight.radiosity);
    std::printf("  another seed: %.2f %%\n", 100 * noise);
    options.seed = 1;
    for (int axis = 0; axis < 3; ++axis) {
        Scene turned = scene;
        turned.medium.density = quarterTurned(*scene.medium.density, axis);
        turned.suns[0].direction = quarterTurn(scene.suns[0].direction, axis);
        turned.points[0].position = quarterTurn(scene.points[0].position, axis);
        const Illumination lit = illuminate(turned, options);
        const auto back = openvdb::FloatGrid::create();
        auto accessor = back->getAccessor();
        const auto& radiosity = static_cast<const openvdb::FloatGrid&>(*lit.radiosity);
        for (auto on = scene.medium.density->cbeginValueOn(); on; ++on)
            accessor.setValue(on.getCoord(), radiosity.tree().getValue(quarterTurn(on.getCoord(), axis)));
        const double difference = blockDifference(*scene.medium.density, *back, *straight.radiosity);
        std::printf("  turned about axis %d: %.2f %%\n", axis, 100 * difference);
        EXPECT_LE(difference, 0.01);
        EXPECT_LE(std::abs(lit.power.absorbed[0] / straight.power.absorbed[0] - 1), 0.005);
    }
}

TEST(InvarianceSlow, OfTheInterpolation) {
    const Scene scene = cloudScene(false);
    IlluminateOptions options = fixedSweeps(512);
    const Illumination nearest = illuminate(scene, options);
    options.interpolation = Interpolation::linear;
    const Illumination linear = illuminate(scene, options);
    const double difference = blockDifference(*scene.medium.density, *linear.radiosity, *nearest.radiosity);
    std::printf("  linear against nearest: %.2f %%\n", 100 * difference);
    EXPECT_LE(difference, 0.01);
}
