// Inputs at the edge of what is possible: each has an expected outcome.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "raysweep/core/error.h"
#include "raysweep/illuminate/illuminate.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

IlluminateOptions fixedSweeps(int sweeps) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = sweeps;
    return options;
}

Scene furnaceScene(const openvdb::FloatGrid::ConstPtr& density, double extinctionScale = 1) {
    Scene scene;
    scene.medium.density = density;
    scene.medium.extinctionScale = extinctionScale;
    scene.medium.albedo = grey(1);
    scene.sky.radiance = grey(1);
    return scene;
}

}  // namespace

// Balls of one optical depth per voxel are lit evenly from all sides, so radiosity is 1 in all of them.
TEST(Extremes, OpticalDepthsOfAnySizeStayInTheFurnace) {
    const auto density = noiseBall(6, 1, 1);
    for (const double depth : {1e-8, 1e-6, 1e-4, 1e-2, 1.0, 10.0, 1e3, 1e6, 1e8}) {
        const Illumination lit = illuminate(furnaceScene(density, depth), fixedSweeps(2048));
        const Departure now = fromOne(*lit.radiosity, *density);
        std::printf("  depth %g: mean %.5f rms %.5f balance %.1e\n", depth, now.mean, now.rms, lit.power.error());
        EXPECT_LE(lit.power.error(), 1e-5) << depth;
        // However thick the voxels, what they shoot in a sweep is the same share of what they have.
        // The noise of 2048 directions for the few voxels that shade all others.
        EXPECT_LE(std::abs(now.mean - 1), 4e-3) << depth;
        EXPECT_LE(now.rms, 8e-3) << depth;
    }
}

TEST(Extremes, SurfaceOfAWallIsLitAsMuchAsTheSky) {
    // Only the outermost voxels see the sky; whatever they collect they give back, having albedo 1.
    const auto density = boxVolume({1, 1, 1});
    for (const double depth : {1e-8, 1.0, 1e3, 1e8}) {
        const Illumination lit = illuminate(furnaceScene(density, depth), fixedSweeps(4096));
        const Departure now = fromOne(*lit.radiosity, *density);
        std::printf("  one voxel of depth %g: radiosity %.5f, %d finishing sweeps\n", depth, now.mean,
                    lit.finishingSweeps);
        // The noise of 4096 directions, of which each brings what the voxel's cross-section is along it.
        EXPECT_LE(std::abs(now.mean - 1), 2e-3) << depth;
        EXPECT_LE(lit.power.error(), 1e-5);
    }
}

TEST(Extremes, AlbedoZeroIsLitDirectlyAndOnlyBySourcesOfItsOwn) {
    Scene scene = furnaceScene(boxVolume({8, 8, 8}));
    scene.medium.albedo = grey(0);
    scene.suns.push_back({});
    const Illumination lit = illuminate(scene);
    EXPECT_EQ(lit.sweeps, 0);
    EXPECT_EQ(lit.unshot, nullptr);
    EXPECT_EQ(fromOne(*lit.radiosity, *scene.medium.density).mean, 0);  // nothing scatters, nothing emits
}

TEST(Extremes, TinyAndFullRelaxationAgree) {
    Scene scene = furnaceScene(boxVolume({8, 8, 8}), 0.1);
    // Shooting a millionth per sweep takes a million sweeps to finish; the books are right at any time.
    IlluminateOptions options = fixedSweeps(64);
    options.zeta = 1e-6;
    options.remaining = Remaining::drop;
    const Illumination slow = illuminate(scene, options);
    EXPECT_LE(slow.power.error(), 1e-5);
    EXPECT_GT(slow.power.unshot[0], 0.9 * (slow.power.injected[0] - slow.power.escaped[0]));
    options = fixedSweeps(1024);
    options.zeta = 1;
    const Illumination full = illuminate(scene, options);
    const Departure now = fromOne(*full.radiosity, *scene.medium.density);
    EXPECT_LE(full.power.error(), 1e-5);
    EXPECT_LE(std::abs(now.mean - 1), 2e-3);
}

// The same cloud in other units: lengths scale, optical depths and the answer do not. OpenVDB refuses transforms whose
// determinant is below about 3e-15, so 1.5e-5 is the smallest voxel there can be.
TEST(Extremes, VoxelSizeOnlySetsTheUnit) {
    EXPECT_THROW(openvdb::math::Transform::createLinearTransform(1e-6), openvdb::ArithmeticError);
    const auto density = cloudVolume(24);
    openvdb::GridBase::Ptr reference;
    for (const double size : {1.0, 2e-5, 1e-3, 1e3, 1e6}) {
        auto scaled = density->deepCopy();
        scaled->setTransform(openvdb::math::Transform::createLinearTransform(size));
        Scene scene;
        scene.medium.density = scaled;
        scene.medium.extinctionScale = 0.2 / size;
        scene.suns.push_back({Vec3(0.3, -1, 0.2), grey(1)});
        scene.points.push_back({Vec3(5, 6, 30) * size, grey(float(1000 * size * size))});
        scene.sky.radiance = grey(0.1f);
        const Illumination lit = illuminate(scene, fixedSweeps(40));
        EXPECT_LE(lit.power.error(), 1e-5) << size;
        if (!reference) reference = lit.radiosity;
        // Rounding of step lengths and of the fit of escape probabilities, which is made anew for each transform.
        EXPECT_LE(relativeDifference(*lit.radiosity, *reference, *density), 1e-4) << size;
    }
}

TEST(Extremes, OneActiveTileOf4096CubedIsRefusedWithTheMemoryItNeeds) {
    auto grid = openvdb::FloatGrid::create();
    grid->tree().addTile(2, openvdb::Coord(0), 1.0f, true);  // one node of the root's children: 4096^3 voxels
    if (grid->activeVoxelCount() != 4096ull * 4096 * 4096) {
        grid->clear();
        grid->tree().root().addTile(openvdb::Coord(0), 1.0f, true);
    }
    ASSERT_EQ(grid->activeVoxelCount(), 4096ull * 4096 * 4096);
    try {
        illuminate(furnaceScene(grid));
        FAIL() << "accepted";
    } catch (const InvalidArgument& error) {
        EXPECT_NE(std::string(error.what()).find("GB"), std::string::npos) << error.what();
    }
}

TEST(Extremes, VoxelsAMillionApartCostNoMoreThanTheFront) {
    auto grid = openvdb::FloatGrid::create();
    for (const int x : {-1000000, 1000000}) grid->tree().setValue({x, x, -x}, 1.0f);
    Scene scene = furnaceScene(grid);
    scene.medium.albedo = grey(0.5f);
    const Illumination lit = illuminate(scene, fixedSweeps(20));
    EXPECT_LE(lit.power.error(), 1e-5);
    const Departure now = fromOne(*lit.radiosity, *grid);
    std::printf("  two voxels: radiosity %.4f\n", now.mean);
    // Each is on its own: albedo p (1 - p(1 - albedo))^-1 of one voxel of optical depth 1, between 0.3 and 0.5.
    EXPECT_GT(now.mean, 0.2);
    EXPECT_LT(now.mean, 0.55);
}

TEST(Extremes, AClusterFarFromTheOriginIsLitAsAtTheOrigin) {
    const auto near = cloudVolume(16);
    const auto far = openvdb::FloatGrid::create();
    for (auto on = near->cbeginValueOn(); on; ++on)
        far->tree().setValue(on.getCoord().offsetBy(1000000, -1000000, 999992), *on);
    Scene scene = furnaceScene(near, 0.3);
    scene.suns.push_back({Vec3(0.3, -1, 0.2), grey(1)});
    const Illumination a = illuminate(scene, fixedSweeps(20));
    scene.medium.density = far;
    const Illumination b = illuminate(scene, fixedSweeps(20));
    const auto moved = openvdb::FloatGrid::create();
    for (auto on = near->cbeginValueOn(); on; ++on)
        moved->tree().setValue(on.getCoord(), static_cast<const openvdb::FloatGrid&>(*b.radiosity)
                                                  .tree()
                                                  .getValue(on.getCoord().offsetBy(1000000, -1000000, 999992)));
    // The offsets are multiples of 8, so the same rays meet the same voxels.
    EXPECT_EQ(relativeDifference(*moved, *a.radiosity, *near), 0);
}

TEST(Extremes, AnEmptyGridIsLitAsNothing) {
    for (const Vec3& sun : {Vec3(0, 0, -1), Vec3(1, 2, 3)}) {
        Scene scene = furnaceScene(openvdb::FloatGrid::create());
        scene.suns.push_back({sun, grey(1)});
        scene.points.push_back({Vec3(0), grey(1)});
        const Illumination lit = illuminate(scene);
        EXPECT_EQ(lit.activeVoxels, 0u);
        EXPECT_EQ(lit.radiosity->activeVoxelCount(), 0u);
        EXPECT_LE(lit.power.error(), 1e-5);
    }
}

TEST(Extremes, VoxelsWithoutMeaningAreRefusedByCoordinate) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity, -1.0f}) {
        auto grid = boxVolume({8, 8, 8});
        grid->tree().setValue({3, 4, 5}, bad);
        for (const bool asEmission : {false, true}) {
            Scene scene = furnaceScene(asEmission ? boxVolume({8, 8, 8}) : grid);
            if (asEmission) scene.medium.emission = grid;
            try {
                illuminate(scene, fixedSweeps(1));
                FAIL() << bad << " accepted";
            } catch (const InvalidArgument& error) {
                const std::string message = error.what();
                const bool named =
                    message.find("3, 4, 5") != std::string::npos || message.find("3,4,5") != std::string::npos;
                EXPECT_TRUE(named) << message;
            }
        }
    }
}

TEST(Extremes, DenormalsAreAsGoodAsNothing) {
    constexpr float kDenormal = 1e-40f;
    auto grid = boxVolume({16, 16, 16}, kDenormal);
    grid->tree().setValue({5, 5, 5}, 0.5f);
    Scene scene = furnaceScene(grid);
    scene.suns.push_back({Vec3(1, 0.1, 0.2), grey(1)});
    const Illumination lit = illuminate(scene, fixedSweeps(64));
    EXPECT_LE(lit.power.error(), 1e-5);
    std::size_t bad = 0;
    for (auto v = static_cast<const openvdb::FloatGrid&>(*lit.radiosity).cbeginValueOn(); v; ++v)
        bad += !(std::isfinite(*v) && *v >= 0);
    EXPECT_EQ(bad, 0u);
    // The one voxel that counts, as if it were alone.
    auto alone = openvdb::FloatGrid::create();
    alone->tree().setValue({5, 5, 5}, 0.5f);
    scene.medium.density = alone;
    const Illumination single = illuminate(scene, fixedSweeps(1024));
    scene.medium.density = grid;
    EXPECT_LE(relativeDifference(*illuminate(scene, fixedSweeps(1024)).radiosity, *single.radiosity, *alone), 0.02);
}

TEST(Extremes, FaintAndGlaringLightScale) {
    const auto density = cloudVolume(16);
    openvdb::GridBase::Ptr reference;
    for (const float strength : {1.0f, 1e-20f, 1e20f}) {
        Scene scene = furnaceScene(density, 0.2);
        scene.sky.radiance = grey(strength);
        scene.suns.push_back({Vec3(0.3, -1, 0.2), grey(strength)});
        const Illumination lit = illuminate(scene, fixedSweeps(20));
        EXPECT_LE(lit.power.error(), 1e-5) << strength;
        auto scaled = openvdb::gridPtrCast<openvdb::FloatGrid>(lit.radiosity);
        for (auto on = scaled->beginValueOn(); on; ++on) on.setValue(*on / strength);
        if (!reference) reference = scaled;
        EXPECT_LE(relativeDifference(*scaled, *reference, *density), 1e-5) << strength;
    }
}

// Sums of a million floats: rounding must neither lose power nor let the answer drift.
TEST(ExtremesSlow, AMillionSweepsKeepTheBooksAndTheAnswer) {
    for (const float albedo : {1.0f, 0.5f}) {
        Scene scene = furnaceScene(boxVolume({4, 4, 4}, 0.7f));
        scene.medium.albedo = grey(albedo);
        const Illumination lit = illuminate(scene, fixedSweeps(1000000));
        const Illumination fewer = illuminate(scene, fixedSweeps(100000));
        const double change = relativeDifference(*lit.radiosity, *fewer.radiosity, *scene.medium.density);
        const Departure now = fromOne(*lit.radiosity, *scene.medium.density);
        std::printf("  albedo %.1f: balance %.1e, mean %.6f rms %.6f, change since 100000 sweeps %.1e, %.1f s\n",
                    double(albedo), lit.power.error(), now.mean, now.rms, change, lit.seconds.sweeps);
        EXPECT_EQ(lit.sweeps, 1000000);
        EXPECT_LE(lit.power.error(), 1e-5);
        EXPECT_LE(change, 1e-3);  // the noise of 100000 sweeps
        if (albedo == 1) {
            EXPECT_LE(now.rms, 1e-3);
        }
    }
}
