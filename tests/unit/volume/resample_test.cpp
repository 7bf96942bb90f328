#include "raysweep/volume/resample.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/phantoms/phantom.h"
#include "raysweep/volume/coarsen.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/other_grid.h"
#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

namespace {

FloatGrid::Ptr coarse(const FloatGrid& grid, double resolution) {
    return openvdb::gridPtrCast<FloatGrid>(coarsened(grid, resolution));
}

double integralOf(const FloatGrid& grid) {
    double sum = 0;
    for (auto on = grid.cbeginValueOn(); on; ++on) sum += double(*on) * double(on.getVoxelCount());
    return sum * grid.transform().voxelVolume();
}

/// Sparse, on both sides of the origin, with leaves, a tile, and voxels far from all others.
FloatGrid::Ptr scattered() {
    const FloatGrid::Ptr grid = noiseBall(9, 1e-3, 10);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    grid->tree().addTile(1, Coord(16, -24, 8), 0.25f, true);
    grid->tree().setValueOn(Coord(1000000, 3, -1000000), 2.0f);
    grid->tree().setValueOn(Coord(-70, 11, 5), 0.0f);
    return grid;
}

}  // namespace

TEST(Coarsened, AveragesWholeVoxels) {
    const FloatGrid::Ptr grid = FloatGrid::create();
    grid->tree().setValueOn(Coord(0), 1.0f);
    grid->tree().setValueOn(Coord(1, 1, 1), 3.0f);
    grid->tree().setValueOn(Coord(-1, 0, 0), 8.0f);
    const FloatGrid::Ptr half = coarse(*grid, 0.5);
    EXPECT_EQ(half->activeVoxelCount(), 2u);
    EXPECT_FLOAT_EQ(half->tree().getValue(Coord(0)), 4 / 8.0f);
    EXPECT_FLOAT_EQ(half->tree().getValue(Coord(-1, 0, 0)), 8 / 8.0f);
    EXPECT_EQ(half->background(), 0);
}

// 1/0.4 = 2.5: coarse voxel 0 holds the fine voxels 0, 1 and half of 2, coarse voxel 1 the other half.
TEST(Coarsened, SharesVoxelsOutByOverlap) {
    const FloatGrid::Ptr grid = FloatGrid::create();
    grid->tree().setValueOn(Coord(2, 0, 0), 1.0f);
    const FloatGrid::Ptr result = coarse(*grid, 0.4);
    EXPECT_EQ(result->activeVoxelCount(), 2u);
    EXPECT_FLOAT_EQ(result->tree().getValue(Coord(0)), 0.2f * 0.4f * 0.4f);
    EXPECT_FLOAT_EQ(result->tree().getValue(Coord(1, 0, 0)), 0.2f * 0.4f * 0.4f);
}

TEST(Coarsened, PutsVoxelsWhereTheFineOnesWere) {
    const double rows[] = {.1, 0, 0, 0, .05, .2, 0, 0, 0, .02, .3, 0, 1, 2, 3, 1};
    const openvdb::Mat4d matrix(rows);
    const FloatGrid::Ptr grid = FloatGrid::create();
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    grid->tree().setValueOn(Coord(0), 1.0f);
    for (const double resolution : {0.5, 0.7, 1 / 3.0, 0.01}) {
        const FloatGrid::Ptr result = coarse(*grid, resolution);
        // The low corners of voxel (0,0,0) coincide; its other corners lie 1/resolution times as far.
        const Vec3d low = grid->indexToWorld(Vec3d(-0.5)), high = grid->indexToWorld(Vec3d(0.5));
        EXPECT_LT((result->indexToWorld(Vec3d(-0.5)) - low).length(), 1e-12);
        EXPECT_LT((result->indexToWorld(Vec3d(0.5)) - low - (high - low) / resolution).length(), 1e-12 / resolution);
    }
}

// Float storage of the coarse voxels: 6e-8 each, of either sign.
TEST(Coarsened, KeepsTheIntegral) {
    const FloatGrid::Ptr grid = scattered();
    const double exact = integralOf(*grid);
    for (const double resolution : {0.999, 0.9, 0.7, 0.5, 1 / 3.0, 0.1, 0.01, 1e-4, 1e-7})
        EXPECT_NEAR(integralOf(*coarse(*grid, resolution)) / exact, 1, 1e-6) << resolution;
}

// Rounding must not leave slivers beside voxels whose faces coincide.
TEST(Coarsened, MakesAsFewVoxelsAsCoverTheFineOnes) {
    const FloatGrid::Ptr grid = boxVolume(Index3(210, 30, 30));
    for (const int factor : {1, 2, 3, 5, 6, 10, 15, 30})
        EXPECT_EQ(coarse(*grid, 1.0 / factor)->activeVoxelCount(),
                  openvdb::Index64(210 * 30 * 30 / std::pow(factor, 3)))
            << factor;
    // A rounded 1/3 leaves overlaps of 3e-4 that are real.
    EXPECT_EQ(coarse(*grid, 0.3333)->activeVoxelCount(), 70u * 10 * 10);
    EXPECT_EQ(coarse(*grid, 0.3334)->activeVoxelCount(), 71u * 11 * 11);
}

TEST(Coarsened, TilesCountAsTheirVoxels) {
    const FloatGrid::Ptr tiles = FloatGrid::create();
    tiles->tree().addTile(2, Coord(0), 0.5f, true);
    tiles->tree().addTile(1, Coord(-8, 0, 0), 2.0f, true);
    const FloatGrid::Ptr voxels = tiles->deepCopy();
    voxels->tree().voxelizeActiveTiles();
    for (const double resolution : {0.9, 0.5, 0.3, 0.03}) {
        const FloatGrid::Ptr a = coarse(*tiles, resolution), b = coarse(*voxels, resolution);
        a->tree().voxelizeActiveTiles();
        ASSERT_EQ(a->activeVoxelCount(), b->activeVoxelCount()) << resolution;
        // Adding up a tile at once or voxel by voxel differs in the last bits.
        for (auto on = b->cbeginValueOn(); on; ++on)
            ASSERT_NEAR(a->tree().getValue(on.getCoord()), *on, 1e-6) << on.getCoord();
    }
}

// What is uniform stays a few tiles: 1024^3 voxels would be 4 GB.
TEST(Coarsened, LargeTilesStaySmall) {
    const FloatGrid::Ptr grid = FloatGrid::create();
    for (int i = 0; i < 4; ++i) grid->tree().addTile(2, Coord(0, 0, 128 * i), 1.0f, true);
    const FloatGrid::Ptr half = coarse(*grid, 0.5);
    EXPECT_EQ(half->tree().leafCount(), 0u);
    EXPECT_EQ(half->activeVoxelCount(), grid->activeVoxelCount() / 8);
    const FloatGrid::Ptr huge = FloatGrid::create();
    huge->tree().addTile(3, Coord(0), 1.0f, true);
    EXPECT_THROW(coarsened(*huge, 0.9), InvalidArgument);
}

TEST(Coarsened, IsTheSameForAnyNumberOfThreads) {
    const FloatGrid::Ptr grid = scattered();
    const FloatGrid::Ptr many = coarse(*grid, 0.37);
    const ThreadLimit one(1);
    EXPECT_TRUE(sameBits(*many, *coarse(*grid, 0.37)));
}

TEST(Coarsened, OfNothingIsNothing) {
    EXPECT_EQ(coarse(*FloatGrid::create(), 0.5)->activeVoxelCount(), 0u);
}

TEST(Coarsened, KeepsColoursApart) {
    const Vec3SGrid::Ptr grid = Vec3SGrid::create();
    grid->tree().setValueOn(Coord(0), Vec3s(8, 16, 0));
    const auto half = openvdb::gridPtrCast<Vec3SGrid>(coarsened(*grid, 0.5));
    EXPECT_EQ(half->tree().getValue(Coord(0)), Vec3s(1, 2, 0));
}

TEST(Coarsened, RefusesWhatHasNoMeaning) {
    for (const double resolution : {0.0, -1.0, 1.001, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THROW(coarsened(*FloatGrid::create(), resolution), InvalidArgument) << resolution;
    EXPECT_THROW(coarsened(*test::otherGrid<openvdb::Int32Grid>(), 0.5), InvalidArgument);
    const FloatGrid::Ptr frustum = FloatGrid::create();
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(8)), 0.5, 1));
    EXPECT_THROW(coarsened(*frustum, 0.5), InvalidArgument);
}

// Albedo is what is scattered over what collides: (1 x 0.2 + 3 x 0.8) / (1 + 3).
TEST(AtResolution, WeightsAlbedoByExtinction) {
    Medium medium;
    const FloatGrid::Ptr density = FloatGrid::create();
    const Vec3SGrid::Ptr albedo = Vec3SGrid::create();
    density->tree().setValueOn(Coord(0), 1.0f);
    density->tree().setValueOn(Coord(1, 0, 0), 3.0f);
    density->tree().setValueOn(Coord(4, 0, 0), 5.0f);
    albedo->tree().setValueOn(Coord(0), Vec3s(0.2f, 1, 0));
    albedo->tree().setValueOn(Coord(1, 0, 0), Vec3s(0.8f, 1, 0));
    albedo->tree().setValueOn(Coord(1, 1, 0), Vec3s(0.7f));  // where nothing collides
    medium.density = density;
    medium.albedoGrid = albedo;
    const Medium half = atResolution(medium, 0.5);
    const auto result = openvdb::gridConstPtrCast<Vec3SGrid>(half.albedoGrid);
    const Vec3s value = result->tree().getValue(Coord(0));
    EXPECT_FLOAT_EQ(value[0], 0.65f);
    EXPECT_EQ(value[1], 1);  // exactly: above 1 it would be refused
    EXPECT_EQ(value[2], 0);
    EXPECT_EQ(result->tree().getValue(Coord(2, 0, 0)), Vec3s(0));  // inactive in the fine grid: 0
    EXPECT_EQ(result->transform(), half.density->transform());
    EXPECT_FLOAT_EQ(half.density->tree().getValue(Coord(0)), 0.5f);
}

TEST(AtResolution, OneChangesNothing) {
    Medium medium;
    medium.density = FloatGrid::create();
    EXPECT_EQ(atResolution(medium, 1).density, medium.density);
}

TEST(AtResolution, SaysWhereInTheFineGridAVoxelIsBad) {
    Medium medium;
    const FloatGrid::Ptr density = boxVolume(Index3(8));
    density->tree().setValueOn(Coord(7, 6, 5), -1.0f);
    medium.density = density;
    try {
        atResolution(medium, 0.5);
        FAIL() << "a negative density was accepted";
    } catch (const InvalidArgument& e) {
        EXPECT_NE(std::string(e.what()).find("(7, 6, 5)"), std::string::npos) << e.what();
    }
}

TEST(AtResolution, LeavesEmissionAsItIs) {
    Medium medium;
    medium.density = boxVolume(Index3(8));
    const FloatGrid::Ptr elsewhere = FloatGrid::create();
    elsewhere->setTransform(openvdb::math::Transform::createLinearTransform(0.3));
    medium.emission = elsewhere;
    EXPECT_EQ(atResolution(medium, 0.5).emission, elsewhere);
}

// An albedo of another resolution is that of the voxels that it lies in.
TEST(AtResolution, TakesAlbedoOnOtherVoxels) {
    Medium medium;
    medium.density = boxVolume(Index3(8));
    const FloatGrid::Ptr albedo = boxVolume(Index3(16), 0.3f);
    albedo->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    medium.albedoGrid = albedo;
    const Medium half = atResolution(medium, 0.5);
    EXPECT_EQ(half.albedoGrid->transform(), half.density->transform());
    EXPECT_NEAR(openvdb::gridConstPtrCast<FloatGrid>(half.albedoGrid)->tree().getValue(Coord(1)), 0.3, 1e-6);
}

// Linear interpolation gives linear functions back exactly, on whatever voxels they are wanted.
TEST(SampledOnto, ReproducesALinearFunction) {
    const auto f = [](const Vec3d& p) { return float(2 + 3 * p.x() - p.y() + 0.5 * p.z()); };
    const FloatGrid::Ptr grid = boxVolume(Index3(20));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    for (auto on = grid->beginValueOn(); on; ++on) on.setValue(f(grid->indexToWorld(on.getCoord())));
    const Vec3SGrid::Ptr shape = Vec3SGrid::create();
    const auto transform = openvdb::math::Transform::createLinearTransform(0.13);
    transform->postRotate(0.4, openvdb::math::X_AXIS);
    transform->postTranslate(Vec3d(2, 4, 3));
    shape->setTransform(transform);
    shape->tree().addTile(1, Coord(0), Vec3s(1), true);
    shape->tree().setValueOn(Coord(9, 3, 3), Vec3s(1));
    const auto result = openvdb::gridPtrCast<FloatGrid>(sampledOnto(*grid, *shape, 1));
    EXPECT_EQ(result->activeVoxelCount(), 1000u + 18);  // 10^3 around the tile, 27 around the voxel, 9 of them in both
    EXPECT_EQ(result->transform(), shape->transform());
    for (auto on = result->cbeginValueOn(); on; ++on)
        ASSERT_NEAR(*on, f(result->indexToWorld(on.getCoord())), 1e-5) << on.getCoord();
}
