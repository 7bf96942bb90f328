// Sparse grids made dense.
#include "cube4/dense_volume.h"

#include <gtest/gtest.h>

#include "raysweep/core/error.h"
#include "support/expect_error.h"

using namespace raysweep;
using namespace raysweep::cube4;

TEST(Cube4DenseVolume, HoldsWhatIsWithinItsBox) {
    initializeGrids();
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->tree().setValueOn({-3, 2, 5}, 7);
    grid->tree().setValueOn({100, 2, 5}, 9);  // beside the box, as lit grids reach beyond their medium
    grid->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(127)), 2.0f, true);  // a tile, partly inside
    DenseBox box;
    box.low = Index3(-8, 0, 0);
    box.high = Index3(8, 8, 8);
    const DenseField field = denseField(*grid, box);
    ASSERT_EQ(field.size(), 16u * 8 * 8);
    double sum = 0;
    for (const float value : field) sum += double(value);
    EXPECT_EQ(sum, 7 + 2.0 * 8 * 8 * 8);
    EXPECT_EQ(field[box.indexOf({-3, 2, 5})], 7);
}

TEST(Cube4DenseVolume, IsWholeBlocksAroundActiveVoxels) {
    initializeGrids();
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setName("smoke");
    test::expectError<InvalidArgument>([&] { boxAround(*grid, 1000); }, "grid 'smoke' has no active voxels");
    grid->tree().setValueOn({-3, 2, 15}, 7);
    const DenseBox box = boxAround(*grid, 1000);
    EXPECT_EQ(box.low, Index3(-8, 0, 8));
    EXPECT_EQ(box.high, Index3(0, 8, 16));
    test::expectError<InvalidArgument>([&] { boxAround(*grid, 511); }, "8x8x8 voxels, made dense");
}
