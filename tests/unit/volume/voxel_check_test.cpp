#include "raysweep/volume/voxel_check.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"

#include "support/other_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

template <class Call>
std::string messageOf(const Call& call) {
    try {
        call();
    } catch (const InvalidArgument& e) {
        return e.what();
    }
    return "no error";
}

FloatGrid::Ptr makeGrid() {
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    for (int i = 0; i < 40; ++i) grid->tree().setValueOn(Coord(i, i, i), 0.5f);
    return grid;
}

}  // namespace

TEST(CheckVoxels, AcceptsZeroAndLargeValues) {
    const FloatGrid::Ptr grid = makeGrid();
    grid->tree().setValueOn(Coord(1, 0, 0), 0.0f);
    grid->tree().setValueOn(Coord(2, 0, 0), 1e30f);
    EXPECT_NO_THROW(checkVoxels(*grid, "density"));
}

TEST(CheckVoxels, IgnoresInactiveVoxels) {
    const FloatGrid::Ptr grid = makeGrid();
    grid->tree().setValueOff(Coord(1, 0, 0), kNan);
    EXPECT_NO_THROW(checkVoxels(*grid, "density"));
}

TEST(CheckVoxels, CountsBadVoxelsAndNamesTheFirst) {
    const FloatGrid::Ptr grid = makeGrid();
    grid->tree().setValueOn(Coord(30, 30, 30), kNan);
    grid->tree().setValueOn(Coord(3, 4, 5), -1.0f);
    grid->tree().setValueOn(Coord(20, 20, 20), kInfinity);
    grid->tree().addTile(1, Coord(800, 0, 0), -kInfinity, true);
    std::string messages[2];
    for (int threads = 1; threads <= 2; ++threads) {
        const ThreadLimit limit(threads);
        messages[threads - 1] = messageOf([&] { checkVoxels(*grid, "density"); });
    }
    EXPECT_NE(messages[0].find("density: 515 active voxels"), std::string::npos) << messages[0];
    EXPECT_NE(messages[0].find("(3, 4, 5)"), std::string::npos) << messages[0];
    EXPECT_NE(messages[0].find("repair the file"), std::string::npos) << messages[0];
    EXPECT_EQ(messages[0], messages[1]);
}

TEST(CheckVoxels, CanBeRepaired) {
    const FloatGrid::Ptr grid = makeGrid();
    grid->tree().setValueOn(Coord(3, 4, 5), kNan);
    try {
        checkVoxels(*grid, "density");
        FAIL() << "no error";
    } catch (const InvalidArgument& e) {
        EXPECT_EQ(e.remedy, Remedy::repairVoxels);
    }
}

TEST(CheckVoxels, SeesAnInfiniteTile) {
    const FloatGrid::Ptr grid = makeGrid();
    grid->tree().addTile(1, Coord(800, 0, 0), kInfinity, true);
    EXPECT_NE(messageOf([&] { checkVoxels(*grid, "x"); }).find("(800, 0, 0)"), std::string::npos);
}

TEST(RepairVoxels, SetsBadVoxelsToZeroAndLeavesTheRest) {
    const FloatGrid::Ptr grid = makeGrid();
    grid->tree().setValueOn(Coord(3, 3, 3), kNan);
    grid->tree().setValueOn(Coord(3, 4, 5), -1.0f);
    grid->tree().addTile(1, Coord(800, 0, 0), kInfinity, true);
    EXPECT_EQ(repairVoxels(*grid), 514u);
    EXPECT_NO_THROW(checkVoxels(*grid, "density"));
    EXPECT_EQ(grid->tree().getValue(Coord(3, 3, 3)), 0.0f);
    EXPECT_EQ(grid->tree().getValue(Coord(4, 4, 4)), 0.5f);
    EXPECT_EQ(repairVoxels(*grid), 0u);
}

TEST(RepairVoxels, KeepsTheGoodChannelsOfAColour) {
    const Vec3SGrid::Ptr grid = Vec3SGrid::create();
    grid->tree().setValueOn(Coord(1, 1, 1), Vec3s(0.5f, kNan, -2.0f));
    EXPECT_THROW(checkVoxels(*grid, "emission"), InvalidArgument);
    EXPECT_EQ(repairVoxels(*grid), 1u);
    EXPECT_EQ(grid->tree().getValue(Coord(1, 1, 1)), Vec3s(0.5f, 0.0f, 0.0f));
}

TEST(CheckAlbedo, AcceptsFractionsOnly) {
    const FloatGrid::Ptr grid = makeGrid();
    grid->tree().setValueOn(Coord(1, 0, 0), 1.0f);
    EXPECT_NO_THROW(checkAlbedo(*grid));
    grid->tree().setValueOn(Coord(1, 0, 0), 1.001f);
    EXPECT_THROW(checkAlbedo(*grid), InvalidArgument);
    const Vec3SGrid::Ptr color = Vec3SGrid::create();
    color->tree().setValueOn(Coord(0), Vec3s(1.0f, 0.0f, kNan));
    EXPECT_THROW(checkAlbedo(*color), InvalidArgument);
    EXPECT_THROW(checkAlbedo(*test::otherGrid<openvdb::BoolGrid>()), InvalidArgument);
}

TEST(ClampForHalf, TouchesOnlyWhatHalfCannotHold) {
    const FloatGrid::Ptr grid = makeGrid();
    grid->tree().setValueOn(Coord(1, 0, 0), 7e4f);
    EXPECT_EQ(clampForHalf(*grid), 0u) << "a grid saved as float needs no clamping";
    grid->setSaveFloatAsHalf(true);
    EXPECT_EQ(clampForHalf(*grid), 1u);
    EXPECT_EQ(grid->tree().getValue(Coord(1, 0, 0)), kLargestHalf);
    const Vec3SGrid::Ptr color = Vec3SGrid::create();
    color->setSaveFloatAsHalf(true);
    color->tree().setValueOn(Coord(0), Vec3s(1.0f, 1e9f, 3.0f));
    EXPECT_EQ(clampForHalf(*color), 1u);
    EXPECT_EQ(color->tree().getValue(Coord(0)), Vec3s(1.0f, kLargestHalf, 3.0f));
}

TEST(VoxelizeTiles, KeepsValuesAndCount) {
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    grid->tree().addTile(1, Coord(0), 0.5f, true);
    grid->tree().addTile(2, Coord(128, 0, 0), 0.25f, true);
    const auto count = grid->activeVoxelCount();
    voxelizeTiles(*grid);
    EXPECT_EQ(grid->tree().activeTileCount(), 0u);
    EXPECT_EQ(grid->activeVoxelCount(), count);
    EXPECT_EQ(grid->tree().getValue(Coord(200, 100, 7)), 0.25f);
}

TEST(CheckVoxels, AlbedosAreClampedAndCounted) {
    const FloatGrid::Ptr grid = FloatGrid::create();
    grid->tree().setValueOn(Coord(0), 1.5f);
    grid->tree().setValueOn(Coord(1), -0.5f);
    grid->tree().setValueOn(Coord(2), kNan);
    grid->tree().setValueOn(Coord(3), 0.25f);
    EXPECT_EQ(clampAlbedo(*grid), 3u);
    const float expected[] = {1, 0, 0, 0.25f};
    for (int i = 0; i < 4; ++i) EXPECT_EQ(grid->tree().getValue(Coord(i)), expected[i]);
    checkAlbedo(*grid);
    const Vec3SGrid::Ptr colors = Vec3SGrid::create();
    colors->tree().addTile(1, Coord(0), Vec3s(0.5f, 2, -1), true);
    EXPECT_EQ(clampAlbedo(*colors), 512u);
    EXPECT_EQ(colors->tree().getValue(Coord(3)), Vec3s(0.5f, 1, 0));
}

TEST(CheckVoxels, ResultsAreFinite) {
    const FloatGrid::Ptr grid = FloatGrid::create();
    grid->setName("radiosity");
    grid->tree().setValueOn(Coord(0), -1.0f);
    requireFiniteResult(*grid, "too bright");
    grid->tree().setValueOn(Coord(7, 8, 9), kInfinity);
    const std::string message = messageOf([&] { requireFiniteResult(*grid, "too bright"); });
    EXPECT_NE(message.find("'radiosity': 1 active voxel is infinite or not a number, the first at index (7, 8, 9)"),
              std::string::npos)
        << message;
    EXPECT_NE(message.find("too bright"), std::string::npos);
}
