#include "raysweep/illuminate/illuminate.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

using namespace raysweep;

namespace {

openvdb::FloatGrid::Ptr block(int edge, float density) {
    auto grid = openvdb::FloatGrid::create();
    grid->setName("density");
    grid->denseFill({openvdb::Coord(0), openvdb::Coord(edge - 1)}, density);
    return grid;
}

float valueAt(const openvdb::GridBase::Ptr& grid, const openvdb::Coord& at) {
    return openvdb::gridPtrCast<openvdb::FloatGrid>(grid)->tree().getValue(at);
}

}  // namespace

TEST(Illuminate, FaintVoxelsShineNoMoreThanTheirSurroundings) {
    for (const float density : {1e-12f, 1e-19f, 1e-25f, 1e-33f, 1e-38f}) {
        Scene scene;
        const auto grid = block(8, 0.1f);
        grid->tree().setValue({4, 4, 4}, density);
        scene.medium.density = grid;
        scene.sky.radiance = grey(1);
        const Illumination lit = illuminate(scene);
        // Albedo 0.9 under a sky of 1: no voxel can reach 1, but for noise.
        EXPECT_LT(valueAt(lit.radiosity, {4, 4, 4}), 1.1f) << density;
        EXPECT_GT(valueAt(lit.radiosity, {4, 4, 4}), 0.5f) << density;
    }
}

TEST(Illuminate, EmptyVoxelsHoldNoPower) {
    Scene scene;
    const auto grid = block(8, 0.1f);
    for (int i = 0; i < 8; ++i) grid->tree().setValue({i, 3, 5}, 0.0f);
    scene.medium.density = grid;
    scene.sky.radiance = grey(1);
    IlluminateOptions options;
    options.sweeps = 32;
    options.remaining = Remaining::drop;
    const Illumination lit = illuminate(scene, options);
    for (int i = 0; i < 8; ++i) EXPECT_EQ(valueAt(lit.unshot, {i, 3, 5}), 0.0f);
    EXPECT_GT(valueAt(lit.unshot, {3, 4, 5}), 0.0f);
}

TEST(Illuminate, AFarPointLightIsASun) {
    const double distance = 1e6, irradiance = 2;
    Scene sun, point;
    sun.medium.density = point.medium.density = block(8, 1e-3f);
    sun.suns.push_back({Vec3(-1, 0, 0), grey(float(irradiance))});
    point.points.push_back({Vec3(distance, 3.5, 3.5), grey(float(irradiance * 4 * kPi * distance * distance))});
    IlluminateOptions options;
    options.sweeps = 0;
    const Illumination bySun = illuminate(sun, options), byPoint = illuminate(point, options);
    for (const openvdb::Coord at : {openvdb::Coord(1, 3, 3), openvdb::Coord(6, 2, 5)}) {
        const double expected = double(valueAt(bySun.radiosity, at));
        // The source is 1e6 voxels away: 1e-5 in distance; thin voxels, so attenuation is below 1 %.
        EXPECT_NEAR(double(valueAt(byPoint.radiosity, at)) / expected, 1, 1e-3);
    }
}

TEST(Illuminate, StoppedWhileFinishingItSpreadsWhatIsLeft) {
    Scene scene;
    scene.medium.density = block(16, 0.2f);
    scene.sky.radiance = grey(1);
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = 20;
    options.unshotShare = 1e-9;
    const Illumination lit =
        illuminate(scene, options, [](const std::string& stage, double) { return stage != "finishing"; });
    EXPECT_EQ(lit.termination, Termination::interrupted);
    EXPECT_LT(lit.power.error(), 1e-5);
    IlluminateOptions dropping = options;
    dropping.remaining = Remaining::drop;
    EXPECT_GT(valueAt(lit.radiosity, {8, 8, 8}), valueAt(illuminate(scene, dropping).radiosity, {8, 8, 8}));
}
