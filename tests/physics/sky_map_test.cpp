// Sky maps in the solver: that they light as the same light does when it is given by other means, and as formulas say.
#include "raysweep/scene/sky_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/illuminate/illuminate.h"
#include "support/blocks.h"
#include "support/closed_forms.h"
#include "support/painted_map.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

/// So little is scattered that the fluence is that of the sky alone, and what is scattered shows it.
constexpr float kProbe = 1e-4f;

void addMap(Scene& scene, const Image& map, const SkyMapOptions& options = {}) {
    const SkyMapLight light = lightFromSkyMap(map, options);
    scene.sky = light.sky;
    scene.suns.insert(scene.suns.end(), light.suns.begin(), light.suns.end());
}

IlluminateOptions fixedSweeps(int sweeps) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = sweeps;
    return options;
}

Scene scatteringBox() {
    Scene scene;
    scene.medium.density = boxVolume({8, 12, 20});
    scene.medium.extinctionScale = 0.2;
    scene.medium.albedo = grey(0.9f);
    return scene;
}

/// Mean fluence over the active voxels.
double meanFluence(const Scene& scene, const IlluminateOptions& options) {
    const Illumination lit = illuminate(scene, options);
    double sum = 0;
    for (auto on = scene.medium.density->cbeginValueOn(); on; ++on)
        sum += double(openvdb::gridPtrCast<openvdb::FloatGrid>(lit.radiosity)->tree().getValue(on.getCoord()));
    return 4 * kPi * sum / double(scene.medium.density->activeVoxelCount()) / double(kProbe);
}

/// An absorbing slab across z that repeats sideways.
Scene absorbingSlab(double opticalThickness) {
    constexpr int kLayers = 16;
    Scene scene;
    scene.medium.density = boxVolume({8, 8, kLayers});
    scene.medium.extinctionScale = opticalThickness / kLayers;
    scene.medium.albedo = grey(kProbe);
    return scene;
}

IlluminateOptions periodic(int sweeps) {
    IlluminateOptions options = fixedSweeps(sweeps);
    options.periodic = {true, true, false};
    return options;
}

Image whiteAbove(int height) {
    return paintedMap(2 * height, height, [](const Vec3& towards) { return grey(towards.z > 0 ? 1 : 0); });
}

/// A sun of 0.7 degrees' radius over a dim sky that gets brighter to one side.
Image sunnyMap(const Vec3& towardsSun) {
    return paintedMap(1024, 512, [&](const Vec3& towards) {
        return inDisc(towards, towardsSun, 0.012) ? grey(4000) : grey(float(0.1 + 0.05 * towards.y));
    });
}

}  // namespace

TEST(SkyMapLight, AConstantMapLightsAsAConstantSky) {
    Scene constant = scatteringBox(), mapped = constant;
    constant.sky.radiance = grey(0.7f);
    addMap(mapped, paintedMap(64, 32, [](const Vec3&) { return grey(0.7f); }));
    const IlluminateOptions options = fixedSweeps(40);
    EXPECT_TRUE(sameBits(*illuminate(mapped, options).radiosity, *illuminate(constant, options).radiosity));
}

TEST(SkyMapLight, AFurnaceUnderAMapOfOnesIsOne) {
    Scene scene;
    scene.medium.density = noiseBall(10, 1e-3, 5);
    scene.medium.albedo = grey(1);
    addMap(scene, paintedMap(100, 50, [](const Vec3&) { return grey(1); }));
    const Departure now = fromOne(*illuminate(scene, fixedSweeps(1024)).radiosity, *scene.medium.density);
    std::printf("  mean %.6f rms %.5f\n", now.mean, now.rms);
    EXPECT_NEAR(now.mean, 1, 1e-3);  // furnace_test.cpp has half of it, for three times as many voxels
    EXPECT_LE(now.rms, 5e-3);
}

// Diffuse light from above through an absorber: phi(t) = 2 pi E2(t), whose mean is 2 pi (1/2 - E3(tau)) / tau.
TEST(SkyMapLight, HalfASkyOnASlab) {
    for (const double tau : {0.3, 1.0, 3.0}) {
        Scene scene = absorbingSlab(tau);
        addMap(scene, whiteAbove(64));
        EXPECT_TRUE(scene.suns.empty());
        const double exact = 2 * kPi * (0.5 - exponentialIntegral(3, tau)) / tau;
        const double measured = meanFluence(scene, periodic(4096));
        std::printf("  thickness %g: fluence %.4f, exact %.4f\n", tau, measured, exact);
        // How evenly 4096 directions lie, as in slab_test.cpp.
        EXPECT_NEAR(measured / exact, 1, 5e-3) << tau;
    }
}

// Where nothing attenuates, fluence is the integral of the radiance over the sphere.
TEST(SkyMapLight, AThinBlockSeesTheIntegralOfTheMap) {
    Scene scene;
    scene.medium.density = boxVolume({8, 8, 8}, 1e-5f);
    scene.medium.albedo = grey(kProbe);
    Scene half = scene, sunny = scene;
    addMap(half, whiteAbove(64));
    const Image map = sunnyMap(Vec3(-0.48, 0.36, -0.8));
    addMap(sunny, map);
    // Directions beyond the horizon of 256 or of 4096: a fraction of one per cent of them.
    EXPECT_NEAR(meanFluence(half, fixedSweeps(4096)) / (2 * kPi), 1, 5e-3);
    EXPECT_NEAR(meanFluence(sunny, fixedSweeps(256)) / integralOf(map).x, 1, 5e-3);
}

// A sun of solid angle w and radiance L at cosine mu: phi = L w (1 - exp(-tau/mu)) / (tau/mu), over the part of the sky
// that is everywhere.
TEST(SkyMapLight, ATinyDiscOnASlab) {
    const Vec3 towardsSun(0.48, 0.36, 0.8);
    const Image map = sunnyMap(towardsSun);
    Scene scene;
    const double disc = [&] {
        double sum = 0;
        for (int y = 0; y < map.height; ++y)
            for (int x = 0; x < map.width; ++x)
                if (map.at(x, y)[0] > 1) sum += double(map.at(x, y)[0]) * pixelSolidAngle(map, y);
        return sum;
    }();
    for (const double tau : {0.3, 1.0, 3.0}) {
        scene = absorbingSlab(tau);
        addMap(scene, map);
        EXPECT_EQ(scene.suns.size(), 1u);
        const double slant = tau / towardsSun.z, exactSun = disc * -std::expm1(-slant) / slant;
        // The sky's part of y cancels between opposite sides; it shines from above and below.
        const double exactSky = 2 * 0.1 * 2 * kPi * (0.5 - exponentialIntegral(3, tau)) / tau;
        const double measured = meanFluence(scene, periodic(128)), exact = exactSun + exactSky;
        scene = absorbingSlab(tau);
        SkyMapOptions without;
        without.suns = 0;
        addMap(scene, map, without);
        const double byChance = meanFluence(scene, periodic(128));
        std::printf("  thickness %g: fluence %.4f, without suns %.4f, exact %.4f\n", tau, measured, byChance, exact);
        // A third is the sky's, of which 128 directions are 2 % off.
        EXPECT_NEAR(measured / exact, 1, 0.01) << tau;
        EXPECT_GT(std::abs(byChance / exact - 1), 0.1) << "chance would have done as well";
    }
}

// A voxel's mean fluence is what it collides over tau h^2. It lets p(tau) of what is isotropic through, so half a sky
// gives 2 pi p; a sun along an axis gives its irradiance times (1 - exp(-tau)) / tau.
TEST(SkyMapLight, AVoxelOfOneOpticalDepth) {
    Scene scene;
    scene.medium.density = boxVolume({1, 1, 1});
    scene.medium.albedo = grey(kProbe);
    Scene half = scene, sunny = scene;
    addMap(half, whiteAbove(32));
    EXPECT_NEAR(meanFluence(half, fixedSweeps(4096)) / (2 * kPi * escapeProbability(1)), 1,
                0.005);  // evenness of directions
    const Image map = paintedMap(2048, 1024, [](const Vec3& towards) {
        return grey(inDisc(towards, {0, 0, 1}, 0.008) ? 4000 : 0);
    });
    addMap(sunny, map);
    ASSERT_EQ(sunny.suns.size(), 1u);
    const double exact = integralOf(map).x * -std::expm1(-1.0);
    // The kernel's p is 2e-4 off, and the disc is left with 4 / (4 pi) of its solid angle, 6e-5, for the sweeps.
    EXPECT_NEAR(meanFluence(sunny, fixedSweeps(64)) / exact, 1, 5e-4);
}

TEST(SkyMapLight, AMapOfASunIsThatSunAfterFewSweeps) {
    const Vec3 towardsSun = Vec3(0.3, -0.5, 0.8).normalized();
    const auto onlySun = [&](const Vec3& towards) { return grey(inDisc(towards, towardsSun, 0.012) ? 4000 : 0); };
    const Image map = paintedMap(1024, 512, onlySun);
    Scene mapped = scatteringBox(), explicitly = scatteringBox(), byChance = scatteringBox();
    addMap(mapped, map);
    SkyMapOptions without;
    without.suns = 0;
    addMap(byChance, map, without);
    explicitly.suns.push_back({-towardsSun, grey(float(integralOf(map).x))});
    const auto radiosity = [](const Scene& scene, int sweeps) {
        return illuminate(scene, fixedSweeps(sweeps)).radiosity;
    };
    const auto reference = radiosity(explicitly, 1024);
    const double explicit64 = relativeDifference(*radiosity(explicitly, 64), *reference, *mapped.medium.density);
    const double mapped64 = relativeDifference(*radiosity(mapped, 64), *reference, *mapped.medium.density);
    const double chance64 = relativeDifference(*radiosity(byChance, 64), *reference, *mapped.medium.density);
    std::printf("  64 sweeps against 1024 of the sun itself: sun %.4f, map %.4f, map without suns %.4f\n", explicit64,
                mapped64, chance64);
    // What a few sweeps cannot know is the light scattered more than once; the map adds next to nothing to that.
    EXPECT_LE(mapped64, explicit64 + 0.003);
    EXPECT_GT(chance64, 10 * mapped64);
}

TEST(SkyMapLight, TurnsWithTheScene) {
    const Image map = sunnyMap(Vec3(0.48, 0.36, 0.8));
    IlluminateOptions options = fixedSweeps(512);
    for (int up = 0; up < 3; ++up) {
        Scene scene = scatteringBox();
        SkyMapOptions sky;
        sky.up = up;
        addMap(scene, map, sky);
        const auto lit = openvdb::gridPtrCast<openvdb::FloatGrid>(illuminate(scene, options).radiosity);
        const auto density = quarterTurned(*scene.medium.density, up);
        const auto difference = [&](double rotate) {
            Scene turned = scatteringBox();
            turned.medium.density = density;
            sky.rotate = rotate;
            addMap(turned, map, sky);
            const DenseVolume weights = dense(*density, *density);
            return blockError(dense(*illuminate(turned, options).radiosity, *density, 0).values,
                              dense(*quarterTurned(*lit, up), *density).values, weights.values, weights.size);
        };
        const double right = difference(90), wrong = difference(-90);
        std::printf("  up %d: turned %.4f, turned the other way %.4f\n", up, right, wrong);
        EXPECT_LE(right, 0.01);  // as invariance_test.cpp has it for quarter turns
        EXPECT_GT(wrong, 0.1);
    }
}
