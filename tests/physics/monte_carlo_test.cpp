// The whole solver against an independent Monte Carlo solution of the same voxels.
//
// Compared are averages over blocks of 4^3 voxels: single voxels keep the noise of the last few directions, and nobody
// looks at single voxels.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "raysweep/illuminate/illuminate.h"
#include "support/blocks.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr int kEdge = 32;
enum class Shape { cube, ball, cloud };
enum class Light { sun, sky, pointInside, pointOutside, emission };
const char* const kShapeNames[] = {"cube", "ball", "cloud"};
const char* const kLightNames[] = {"sun", "sky", "point inside", "point outside", "emission"};

struct Case {
    Shape shape;
    Light light;
    double opticalThickness;  ///< of 32 voxels of full density
    float albedo;
};

openvdb::FloatGrid::Ptr volumeOf(Shape shape) {
    switch (shape) {
        case Shape::cube:
            return boxVolume(Index3(kEdge));
        case Shape::ball:
            return ballVolume(kEdge);
        default:
            return cloudVolume(kEdge);
    }
}

Scene sceneOf(const Case& c) {
    Scene scene;
    const auto density = volumeOf(c.shape);
    scene.medium.density = density;
    scene.medium.extinctionScale = c.opticalThickness / kEdge;
    scene.medium.albedo = grey(c.albedo);
    switch (c.light) {
        case Light::sun:
            scene.suns.push_back({Vec3(0.3, -1, 0.2), grey(1)});
            break;
        case Light::sky:
            scene.sky.radiance = grey(1);
            break;
        // Neither in the middle of a voxel nor on a border.
        case Light::pointInside:
            scene.points.push_back({Vec3(14.3, 12.1, 8.7), grey(1000)});
            break;
        case Light::pointOutside:
            scene.points.push_back({Vec3(-9.7, 45.2, 20.4), grey(1000)});
            break;
        case Light::emission: {
            auto emission = density->deepCopy();
            for (auto on = emission->beginValueOn(); on; ++on) on.setValue(on.getCoord().x() < 10 ? *on : 0);
            scene.medium.emission = emission;
        }
    }
    return scene;
}

struct Comparison {
    double error = 0;  ///< relative RMS of block averages
    double noise = 0;  ///< the reference's own share of it
    int sweeps = 0, finishingSweeps = 0;
};

Comparison compare(const Case& c, int sweeps, std::uint64_t histories) {
    const Scene scene = sceneOf(c);
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = sweeps;
    const Illumination lit = illuminate(scene, options);
    const DenseVolume density = dense(*scene.medium.density, *scene.medium.density);
    const DenseVolume ours = dense(*lit.radiosity, *scene.medium.density, 0);
    const McScene mc = monteCarloScene(scene);
    const McResult reference = monteCarlo(mc, histories, 1), again = monteCarlo(mc, histories, 2);
    std::vector<double> mean(reference.sourceRadiance.size());
    for (std::size_t i = 0; i < mean.size(); ++i) {
        mean[i] = 0.5 * (reference.sourceRadiance[i] + again.sourceRadiance[i]);
        // What is emitted is no part of radiosity.
        if (!mc.emission.empty() && mc.extinction[i] > 0) mean[i] -= mc.emission[i] / (4 * kPi * mc.extinction[i]);
    }
    Comparison result{blockError(ours.values, mean, density.values, density.size), 0, lit.sweeps, lit.finishingSweeps};
    // Two independent runs differ by twice what their mean is off.
    result.noise = 0.5 * blockError(again.sourceRadiance, reference.sourceRadiance, density.values, density.size);
    std::printf(
        "  %-5s %-13s thickness %4g (%.3g a voxel) albedo %.2f: error %.2f %% (reference %.2f %%), %d + %d sweeps\n",
        kShapeNames[int(c.shape)], kLightNames[int(c.light)], c.opticalThickness, c.opticalThickness / kEdge,
        double(c.albedo), 100 * result.error, 100 * result.noise, result.sweeps, result.finishingSweeps);
    std::fflush(stdout);
    return result;
}

void expectAgreement(const Case& c) {
    const Comparison result = compare(c, 512, 2000000);
    // Thin voxels: what is left is the noise of 512 directions and the staircase of voxels. At half an optical depth
    // per voxel the voxel itself begins to be too coarse.
    const double tolerance = c.opticalThickness / kEdge <= 0.25 ? 0.02 : 0.035;
    EXPECT_LE(result.error, tolerance);
    EXPECT_LE(result.noise, 0.5 * tolerance) << "the reference is too noisy to judge by";
}

}  // namespace

TEST(MonteCarloSlow, CubeUnderTheSun) {
    expectAgreement({Shape::cube, Light::sun, 1, 0.9f});
    expectAgreement({Shape::cube, Light::sun, 4, 0.5f});
    expectAgreement({Shape::cube, Light::sun, 4, 0.99f});
    expectAgreement({Shape::cube, Light::sun, 16, 0.99f});
}

TEST(MonteCarloSlow, BallUnderTheSun) {
    expectAgreement({Shape::ball, Light::sun, 1, 0.5f});
    expectAgreement({Shape::ball, Light::sun, 4, 0.9f});
    expectAgreement({Shape::ball, Light::sun, 16, 0.9f});
}

TEST(MonteCarloSlow, CloudUnderTheSun) {
    expectAgreement({Shape::cloud, Light::sun, 4, 0.99f});
    expectAgreement({Shape::cloud, Light::sun, 16, 0.5f});
}

TEST(MonteCarloSlow, Sky) {
    expectAgreement({Shape::cloud, Light::sky, 4, 0.9f});
}

TEST(MonteCarloSlow, PointInside) {
    expectAgreement({Shape::cube, Light::pointInside, 4, 0.9f});
}

TEST(MonteCarloSlow, PointOutside) {
    expectAgreement({Shape::ball, Light::pointOutside, 4, 0.9f});
}

TEST(MonteCarloSlow, Emission) {
    expectAgreement({Shape::cube, Light::emission, 4, 0.9f});
    expectAgreement({Shape::cube, Light::emission, 16, 0.5f});
    expectAgreement({Shape::cloud, Light::emission, 4, 0.9f});
}

// Not a check: prints the table of docs/validation.md.
TEST(MonteCarloSlow, DISABLED_Table) {
    for (const Shape shape : {Shape::cube, Shape::ball, Shape::cloud})
        for (const double thickness : {1.0, 4.0, 16.0})
            for (const float albedo : {0.5f, 0.9f, 0.99f})
                compare({shape, Light::sun, thickness, albedo}, 1024, 4000000);
    for (const Light light : {Light::sky, Light::pointInside, Light::pointOutside, Light::emission})
        for (const Shape shape : {Shape::cube, Shape::ball, Shape::cloud})
            for (const double thickness : {4.0, 16.0}) compare({shape, light, thickness, 0.9f}, 1024, 4000000);
    compare({Shape::cube, Light::sun, 64, 0.99f}, 1024, 4000000);
}
