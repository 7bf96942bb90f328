#include "raysweep/volume/statistics.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

TEST(ValueRange, CoversTilesAndLeavesOutWhatIsNotFinite) {
    const FloatGrid::Ptr grid = FloatGrid::create(-100);
    grid->tree().setValueOn(Coord(0), 0.5f);
    grid->tree().setValueOn(Coord(1), std::numeric_limits<float>::quiet_NaN());
    grid->tree().addTile(1, Coord(64, 0, 0), 3.0f, true);
    const ValueRange range = valueRange(*grid);
    ASSERT_EQ(range.min.size(), 1u);
    EXPECT_EQ(range.min[0], 0.5f);
    EXPECT_EQ(range.max[0], 3.0f);
    EXPECT_EQ(range.notFinite, 1u);
}

TEST(ValueRange, OfNothingIsEmptyAndOfColoursPerChannel) {
    EXPECT_TRUE(valueRange(*FloatGrid::create()).min.empty());
    const Vec3SGrid::Ptr grid = Vec3SGrid::create();
    grid->tree().setValueOn(Coord(0), Vec3s(1, 2, 3));
    grid->tree().setValueOn(Coord(9), Vec3s(3, 1, 4));
    const ValueRange range = valueRange(*grid);
    EXPECT_EQ(range.min, (std::vector<float>{1, 1, 3}));
    EXPECT_EQ(range.max, (std::vector<float>{3, 2, 4}));
}

// Three voxels in the union: 1 against 2, a tile's worth is not needed; one is active in each grid only.
TEST(CompareGrids, CountsTheUnionOfActiveVoxels) {
    const FloatGrid::Ptr a = FloatGrid::create(0), b = FloatGrid::create(0);
    a->tree().setValueOn(Coord(0), 1.0f);
    b->tree().setValueOn(Coord(0), 2.0f);
    a->tree().setValueOn(Coord(100, 0, 0), 2.0f);
    b->tree().setValueOn(Coord(0, 100, 0), 4.0f);
    const GridDifference d = compareGrids(*a, *b);
    EXPECT_EQ(d.voxels, 3u);
    EXPECT_DOUBLE_EQ(d.rmse, std::sqrt((1 + 4 + 16) / 3.0));
    EXPECT_DOUBLE_EQ(d.relativeRmse, std::sqrt((1 + 4 + 16) / (4 + 16.0)));
    EXPECT_DOUBLE_EQ(d.psnr, 20 * std::log10(4 / std::sqrt(7.0)));
    EXPECT_EQ(d.max, 4);
    EXPECT_EQ(d.maxAt, Coord(0, 100, 0));
}

TEST(CompareGrids, SeesTilesInEitherGrid) {
    const FloatGrid::Ptr a = FloatGrid::create(0), b = FloatGrid::create(0);
    a->tree().addTile(1, Coord(0), 1.0f, true);
    b->tree().addTile(1, Coord(0), 1.0f, true);
    b->tree().addTile(1, Coord(8, 0, 0), 2.0f, true);
    const GridDifference d = compareGrids(*a, *b);
    EXPECT_EQ(d.voxels, 1024u);
    EXPECT_DOUBLE_EQ(d.rmse, std::sqrt(2.0));
}

TEST(CompareGrids, OfEqualColoursIsZero) {
    const Vec3SGrid::Ptr grid = Vec3SGrid::create();
    grid->tree().setValueOn(Coord(3), Vec3s(1, 2, 3));
    const GridDifference d = compareGrids(*grid, *grid);
    EXPECT_EQ(d.rmse, 0);
    EXPECT_EQ(d.relativeRmse, 0);
    EXPECT_TRUE(std::isinf(d.psnr));
}

TEST(CompareGrids, IsNotANumberWhereAVoxelIsNot) {
    const FloatGrid::Ptr a = FloatGrid::create(0), b = FloatGrid::create(0);
    a->tree().setValueOn(Coord(0), std::numeric_limits<float>::quiet_NaN());
    b->tree().setValueOn(Coord(1), 1.0f);
    EXPECT_TRUE(std::isnan(compareGrids(*a, *b).rmse));
}

TEST(CompareGrids, RefusesWhatCannotBeCompared) {
    const FloatGrid::Ptr a = FloatGrid::create(0), b = FloatGrid::create(0);
    a->tree().setValueOn(Coord(0), 1.0f);
    b->tree().setValueOn(Coord(0), 1.0f);
    b->setTransform(
        openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(8)), 0.5, 1));
    EXPECT_THROW(compareGrids(*a, *b), InvalidArgument);
    EXPECT_THROW(compareGrids(*a, *Vec3SGrid::create()), InvalidArgument);
    EXPECT_THROW(compareGrids(*FloatGrid::create(), *FloatGrid::create()), InvalidArgument);
}

// The coarse grid is 1 at x = 0 and 3 at x = 2; the fine voxels between them expect 1, 2 and 3 and find 1, 2 and 4.
TEST(CompareGrids, InterpolatesTheCoarserWhereVoxelsDoNotCoincide) {
    const FloatGrid::Ptr fine = FloatGrid::create(0), coarse = FloatGrid::create(0);
    coarse->setTransform(openvdb::math::Transform::createLinearTransform(2));
    coarse->tree().setValueOn(Coord(0), 1.0f);
    coarse->tree().setValueOn(Coord(1, 0, 0), 3.0f);
    fine->tree().setValueOn(Coord(0), 1.0f);
    fine->tree().setValueOn(Coord(1, 0, 0), 2.0f);
    fine->tree().setValueOn(Coord(2, 0, 0), 4.0f);
    const GridDifference d = compareGrids(*coarse, *fine), e = compareGrids(*fine, *coarse);
    EXPECT_EQ(d.resampled, GridDifference::Resampled::grid);
    EXPECT_EQ(e.resampled, GridDifference::Resampled::reference);
    EXPECT_EQ(d.voxels, 3u);
    EXPECT_EQ(e.voxels, 3u);
    EXPECT_DOUBLE_EQ(d.rmse, std::sqrt(1 / 3.0));
    EXPECT_DOUBLE_EQ(e.rmse, d.rmse);
    EXPECT_DOUBLE_EQ(d.relativeRmse, std::sqrt(1 / (1 + 4 + 16.0)));
    EXPECT_DOUBLE_EQ(e.relativeRmse, std::sqrt(1 / (1 + 4 + 9.0)));
    EXPECT_EQ(d.maxAt, Coord(2, 0, 0));
    EXPECT_EQ(compareGrids(*fine, *fine).resampled, GridDifference::Resampled::none);
}
