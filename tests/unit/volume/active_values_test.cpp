// The walk over active values meets each once, tiles of every level included, in an order that does not depend on
// threads, and writes to the grid itself.
#include "raysweep/volume/active_values.h"

#include <gtest/gtest.h>

#include <vector>

using namespace raysweep;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;

namespace {

/// Voxels of two leaves and a tile of each level, 8, 128 and 4096 voxels long.
FloatGrid::Ptr mixedGrid() {
    const FloatGrid::Ptr grid = FloatGrid::create(0.0f);
    grid->tree().addTile(3, Coord(8192, 0, 0), 5.0f, true);
    grid->tree().addTile(2, Coord(1024, 0, 0), 4.0f, true);
    grid->tree().addTile(1, Coord(64, 0, 0), 3.0f, true);
    grid->tree().setValueOn(Coord(1, 2, 3), 1.0f);
    grid->tree().setValueOn(Coord(1, 2, 4), 1.5f);
    grid->tree().setValueOff(Coord(2, 2, 2), 9.0f);
    grid->tree().setValueOn(Coord(-1, 0, 0), 2.0f);
    return grid;
}

struct Met {
    float value;
    Coord low;
    openvdb::Index64 voxels;
    bool operator==(const Met& o) const { return value == o.value && low == o.low && voxels == o.voxels; }
};

std::vector<Met> all(const FloatGrid& grid) {
    std::vector<Met> met;
    forEachActive(grid, [&](float value, const CoordBBox& box) { met.push_back({value, box.min(), box.volume()}); });
    return met;
}

}  // namespace

TEST(ActiveValues, AreMetOnceLeavesBeforeTiles) {
    const FloatGrid::Ptr grid = mixedGrid();
    const std::vector<Met> met = all(*grid);
    ASSERT_EQ(met.size(), 6u);
    EXPECT_EQ(met[0], (Met{2.0f, Coord(-1, 0, 0), 1}));
    EXPECT_EQ(met[1], (Met{1.0f, Coord(1, 2, 3), 1}));
    EXPECT_EQ(met[2], (Met{1.5f, Coord(1, 2, 4), 1}));
    EXPECT_EQ(met[3], (Met{3.0f, Coord(64, 0, 0), 512}));
    EXPECT_EQ(met[4], (Met{4.0f, Coord(1024, 0, 0), 128 * 128 * 128}));
    EXPECT_EQ(met[5], (Met{5.0f, Coord(8192, 0, 0), openvdb::Index64(4096) * 4096 * 4096}));
}

TEST(ActiveValues, AreWrittenInPlaceTilesOfEveryLevelToo) {
    const FloatGrid::Ptr grid = mixedGrid();
    setActive(*grid, [] { return [](const Coord& at) { return float(at.x()); }; });
    for (const Met& met : all(*grid)) {
        EXPECT_EQ(met.value, float(met.low.x()));
        EXPECT_EQ(grid->tree().getValue(met.low), float(met.low.x()));
    }
    EXPECT_EQ(grid->tree().getValue(Coord(2, 2, 2)), 9.0f) << "not active";
    EXPECT_EQ(all(*grid).size(), 6u) << "tiles stay tiles";
}

// Terms that cancel in part: another order would show.
TEST(ActiveValues, SumsHaveTheSameBitsForAnyNumberOfThreads) {
    const FloatGrid::Ptr grid = FloatGrid::create(0.0f);
    for (int i = 0; i < 3000; ++i) grid->tree().setValueOn(Coord(9 * i, i % 5, 0), i % 3 ? 1.0f / float(i) : 1e7f);
    const auto sum = [&](int threads) {
        const ThreadLimit limit(threads);
        return sumOverActive<float>(*grid, [](float& s, float value, const CoordBBox&) { s += value; });
    };
    const float one = sum(1);
    EXPECT_GT(one, 1e9f);
    for (const int threads : {2, 3, 7}) EXPECT_EQ(sum(threads), one) << threads;
}
