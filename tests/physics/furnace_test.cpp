// The white furnace: nothing absorbs and light of radiance 1 comes from everywhere, so it is 1 everywhere, and in a
// picture before a background of 1 the volume disappears.
#include "raysweep/illuminate/illuminate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "raysweep/render/render.h"
#include "raysweep/volume/classify.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/vdb_io.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

// What the product promises. The mean is exact but for how evenly directions are spread and for what is left unshot
// (1e-4); single voxels keep the noise of their last few directions, which falls as sweeps are added.
constexpr double kMeanTolerance = 5e-4, kRmsTolerance = 5e-3;

struct Furnace {
    Scene scene;
    IlluminateOptions options;
};

Furnace furnaceWith(const openvdb::FloatGrid::ConstPtr& density, double extinctionScale = 1) {
    Furnace furnace;
    furnace.scene.medium.density = density;
    furnace.scene.medium.extinctionScale = extinctionScale;
    furnace.scene.medium.albedo = grey(1);
    furnace.scene.sky.radiance = grey(1);
    furnace.options.tolerance = 0;
    return furnace;
}

/// Lights with few and with `sweeps` sweeps and checks that the second answer is better, and good.
Illumination expectFurnace(Furnace furnace, int sweeps) {
    const openvdb::FloatGrid& density = *furnace.scene.medium.density;
    furnace.options.sweeps = sweeps / 16;
    const Departure before = fromOne(*illuminate(furnace.scene, furnace.options).radiosity, density);
    furnace.options.sweeps = sweeps;
    Illumination lit = illuminate(furnace.scene, furnace.options);
    const Departure now = fromOne(*lit.radiosity, density);
    std::printf("  %d sweeps: mean %.6f rms %.5f; %d + %d sweeps: mean %.6f rms %.5f, balance %.1e\n", sweeps / 16,
                before.mean, before.rms, lit.sweeps, lit.finishingSweeps, now.mean, now.rms, lit.power.error());
    EXPECT_LT(now.rms, before.rms);
    EXPECT_LE(std::abs(now.mean - 1), kMeanTolerance);
    EXPECT_LE(now.rms, kRmsTolerance);
    EXPECT_LE(lit.power.error(), 1e-5);
    return lit;
}

/// Pictures before a background of 1, along two directions, must be 1.
void expectInvisible(const Furnace& furnace, const Illumination& lit) {
    const RenderInput input{furnace.scene.medium.density, furnace.scene.medium.extinctionScale, lit.radiosity};
    RenderOptions options;
    options.background = grey(1);
    for (const Vec3& up : {Vec3(0, 0, 1), Vec3(0, 1, 0)}) {
        Camera camera;
        camera.up = up;
        camera.width = camera.height = 128;
        const Image image = render(input, framed(camera, worldBounds(*input.density)), options).image;
        double sum = 0, squares = 0, hidden = 0;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) {
                const double value = double(image.at(x, y)[0]);
                sum += value;
                squares += (value - 1) * (value - 1);
                hidden = std::max(hidden, double(image.at(x, y)[3]));
            }
        const double count = double(image.width) * image.height, rms = std::sqrt(squares / count);
        std::printf("  picture: mean %.6f rms %.5f, largest opacity %.3f\n", sum / count, rms, hidden);
        EXPECT_LE(std::abs(sum / count - 1), kMeanTolerance);
        EXPECT_LE(rms, kRmsTolerance);
        EXPECT_GT(hidden, 0.5) << "there was nothing in the picture that could have been seen";
    }
}

}  // namespace

TEST(Furnace, RandomVoxelsDisappear) {
    const Furnace furnace = furnaceWith(noiseBall(16, 1e-6, 10));
    expectInvisible(furnace, expectFurnace(furnace, 1024));
}

TEST(FurnaceSlow, RandomVoxelsDisappearWithLinearInterpolation) {
    Furnace furnace = furnaceWith(noiseBall(12, 1e-6, 10));
    furnace.options.interpolation = Interpolation::linear;
    expectInvisible(furnace, expectFurnace(furnace, 1024));
}

TEST(FurnaceSlow, CloudDisappears) {
    const Furnace furnace = furnaceWith(cloudVolume(48), 0.5);
    expectInvisible(furnace, expectFurnace(furnace, 1024));
}

TEST(FurnaceSlow, SmokeDisappears) {
    const std::string path = findData("vdb/smoke.vdb");
    if (path.empty()) GTEST_SKIP() << "vdb/smoke.vdb is not here; set RAYSWEEP_DATA to the folder of the shared data";
    const VdbFile file = readVdb(path);
    const openvdb::FloatGrid::ConstPtr density = selectDensity(file);
    // About 10 optical depths across.
    const openvdb::Coord size = density->evalActiveVoxelDim();
    const Furnace furnace =
        furnaceWith(density, 10 / (density->voxelSize()[0] * std::max({size.x(), size.y(), size.z()})));
    expectInvisible(furnace, expectFurnace(furnace, 256));
}

// Opacities from 0 to 0.99, so optical depths up to 4.6 per voxel.
TEST(Furnace, ClassifiedVoxelsDisappear) {
    const Furnace furnace = furnaceWith(classify(*noiseBall(16, 1e-3, 10), rampFunction(1e-3, 5)).extinction);
    expectInvisible(furnace, expectFurnace(furnace, 1024));
}

// Solved on coarser voxels and seen in the density as it is: both must be 1.
TEST(Furnace, CoarseVoxelsDisappear) {
    const Furnace furnace = furnaceWith(noiseBall(16, 1e-6, 10), 0.5);
    for (const double resolution : {0.5, 1 / 3.0, 0.7}) {
        std::printf("  resolution %.3g\n", resolution);
        Furnace coarse = furnace;
        coarse.scene = atResolution(furnace.scene, resolution);
        expectInvisible(furnace, expectFurnace(coarse, 1024));
    }
}

TEST(Furnace, EveryWavelengthDisappears) {
    Furnace furnace = furnaceWith(noiseBall(8, 1e-3, 10));
    furnace.scene.sky.radiance = Color(0.5f, 1, 2);
    furnace.options.sweeps = 1024;
    for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear}) {
        furnace.options.interpolation = interpolation;
        const Illumination lit = illuminate(furnace.scene, furnace.options);
        const auto radiosity = openvdb::gridPtrCast<openvdb::Vec3SGrid>(lit.radiosity);
        ASSERT_TRUE(radiosity);
        const auto scaled = radiosity->deepCopy();
        for (auto on = scaled->beginValueOn(); on; ++on)
            on.setValue(openvdb::Vec3s((*on)[0] / 0.5f, (*on)[1], (*on)[2] / 2));
        for (int c = 0; c < 3; ++c) {
            const Departure now = fromOne(*scaled, *furnace.scene.medium.density, c);
            std::printf("  wavelength %d: mean %.6f rms %.5f, balance %.1e\n", c, now.mean, now.rms, lit.power.error());
            EXPECT_LE(std::abs(now.mean - 1), kMeanTolerance);
            EXPECT_LE(now.rms, kRmsTolerance);
        }
        EXPECT_LE(lit.power.error(), 1e-5);
    }
}

namespace {

/// A solid, opacities of 24^3 voxels.
using Opacity = std::function<double(int, int, int)>;

openvdb::FloatGrid::Ptr solidOf(const Opacity& opacity) {
    auto grid = openvdb::FloatGrid::create(0);
    auto accessor = grid->getAccessor();
    for (int x = 0; x < 24; ++x)
        for (int y = 0; y < 24; ++y)
            for (int z = 0; z < 24; ++z)
                if (const double a = std::min(0.99, opacity(x, y, z)); a > 0)
                    accessor.setValue({x, y, z}, float(-std::log1p(-a)));
    return grid;
}

std::vector<std::pair<std::string, Opacity>> softAndNoisySolids() {
    static std::mt19937 random(5);
    const auto gauss = [] { return std::normal_distribution<double>()(random); };
    const auto even = [] { return std::uniform_real_distribution<double>()(random); };
    const auto plate = [=](double noise) {
        return [=](int, int y, int) { return y < 8 || y >= 16 ? 0.0 : 0.3 + noise * gauss(); };
    };
    const auto fromMiddle = [](int x, int y, int z) { return (Vec3(x, y, z) - Vec3(11.5)).length(); };
    return {{"plate", plate(0)},
            {"plate, noise .05", plate(0.05)},
            {"plate, noise .15", plate(0.15)},
            {"plate, noise .3", plate(0.3)},
            {"white noise", [=](int, int, int) { return even(); }},
            {"grains", [=](int, int, int) { return even() < 0.5 ? 1.0 : 0.0; }},
            {"checkerboard", [](int x, int y, int z) { return (x + y + z) % 2 ? 1.0 : 0.0; }},
            {"soft checkerboard", [](int x, int y, int z) { return (x + y + z) % 2 ? 0.6 : 0.2; }},
            {"single voxels", [](int x, int y, int z) { return x % 4 || y % 4 || z % 4 ? 0.0 : 1.0; }},
            {"sheet of one voxel", [](int, int, int z) { return z == 12 ? 1.0 : 0.0; }},
            {"gradient", [](int x, int, int) { return x / 24.0; }},
            {"plates with gaps", [](int x, int, int) { return x % 5 < 3 ? 1.0 : 0.0; }},
            {"cup",
             [](int x, int y, int z) {
                 const auto within = [&](int from, int to) { return x >= from && x < to && y >= from && y < to; };
                 return within(2, 22) && z >= 2 && z < 22 && !(within(5, 19) && z >= 5) ? 1.0 : 0.0;
             }},
            {"noisy ball", [=](int x, int y, int z) { return fromMiddle(x, y, z) < 10 ? 0.9 + 0.1 * gauss() : 0.0; }}};
}

}  // namespace

// With a sky of 1 and no other light nothing can be brighter than its albedo: that would be energy from nowhere. With
// albedo 1 every voxel that can be seen is 1.
TEST(Furnace, SolidsOfAnyKindGiveNoMoreThanTheyGet) {
    for (const auto& [name, opacity] : softAndNoisySolids())
        for (const float albedo : {1.0f, 0.8f}) {
            Furnace furnace = furnaceWith(solidOf(opacity));
            furnace.scene.medium.solid = true;
            furnace.scene.medium.albedo = grey(albedo);
            furnace.options.tolerance = 0.02;
            const Illumination lit = illuminate(furnace.scene, furnace.options);
            const auto radiosity = static_cast<const openvdb::FloatGrid&>(*lit.radiosity).getConstAccessor();
            double most = 0, sum = 0, count = 0;
            for (auto on = furnace.scene.medium.density->cbeginValueOn(); on; ++on) {
                const double S = double(radiosity.getValue(on.getCoord())) / double(albedo);
                most = std::max(most, S);
                if (S == 0) continue;  // deep inside, where nothing is seen
                sum += std::abs(S - 1);
                ++count;
            }
            std::printf("  %s, albedo %.1f: most %.4f, off by %.4f on average; F of a medium %.2f, white %.2f\n",
                        name.c_str(), double(albedo), most, sum / count, lit.mediumFurnaceShare, lit.whiteFurnaceShare);
            EXPECT_LE(most, 1.01) << name;
            EXPECT_LE(lit.power.error(), 1e-5) << name;
            EXPECT_LE(albedo < 1 ? 0 : sum / count, 0.01) << name;
            EXPECT_GE(count, 0.7 * double(furnace.scene.medium.density->activeVoxelCount())) << name;
        }
}
