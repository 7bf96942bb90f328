#include "raysweep/volume/middle_slices.h"

#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"

#include <gtest/gtest.h>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

constexpr int kGap = 4;

/// A value of its own in every voxel of [0, dims), from `least` in steps of 1.
FloatGrid::Ptr numbered(const Index3& dims, float least) {
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    for (int z = 0; z < dims.z; ++z)
        for (int y = 0; y < dims.y; ++y)
            for (int x = 0; x < dims.x; ++x)
                grid->tree().setValueOn(Coord(x, y, z), least + float((z * dims.y + y) * dims.x + x));
    return grid;
}

}  // namespace

TEST(MiddleSlices, LieSideBySideWithTheirAxesToTheRightAndUp) {
    const Index3 dims(10, 12, 9);
    const FloatGrid::Ptr grid = numbered(dims, 1);
    const Image image = middleSlices(*grid, dims);
    ASSERT_EQ(image.width, dims.x + kGap + dims.x + kGap + dims.y);
    ASSERT_EQ(image.height, 12);
    ASSERT_EQ(image.channels, 3);
    const auto expectVoxel = [&](int x, int y, const Coord& voxel) {
        // Grey rises from 0, though no voxel is 0, to the largest value shown. The same arithmetic: no tolerance.
        const float largest = grid->tree().getValue(Coord(dims.x / 2, dims.y - 1, dims.z - 1));
        const float grey = linearFromSrgb(grid->tree().getValue(voxel) / largest);
        for (int c = 0; c < 3; ++c) EXPECT_EQ(image.at(x, y)[c], grey) << voxel << " at " << x << "," << y;
    };
    for (int y = 0; y < dims.y; ++y)
        for (int x = 0; x < dims.x; ++x) expectVoxel(x, y, Coord(x, dims.y - 1 - y, dims.z / 2));
    for (int y = 0; y < dims.z; ++y) {
        for (int x = 0; x < dims.x; ++x) expectVoxel(dims.x + kGap + x, y, Coord(x, dims.y / 2, dims.z - 1 - y));
        for (int x = 0; x < dims.y; ++x) expectVoxel(2 * (dims.x + kGap) + x, y, Coord(dims.x / 2, x, dims.z - 1 - y));
    }
    for (const int x : {dims.x, dims.x + kGap - 1}) EXPECT_EQ(image.at(x, 0)[0], 0);
    EXPECT_EQ(image.at(dims.x + kGap, dims.z)[0], 0) << "below a slice that is lower than others";
}

TEST(MiddleSlices, BeginAtTheSmallestValueIfThatIsBelow0) {
    const Index3 dims(8, 8, 1);
    const Image image = middleSlices(*numbered(dims, -3), dims);
    EXPECT_EQ(image.width, 8) << "thin volumes are shown across z only";
    EXPECT_EQ(image.at(0, 7)[0], 0);
    EXPECT_EQ(image.at(7, 0)[0], 1);
}

TEST(MiddleSlices, HaveTheProportionsOfVoxels) {
    const Index3 dims(8, 9, 10);
    const FloatGrid::Ptr grid = numbered(dims, 1);
    grid->transform().preScale(openvdb::Vec3d(0.5, 0.5, 1.25));
    const Image image = middleSlices(*grid, dims);
    EXPECT_EQ(image.width, 8 + kGap + 8 + kGap + 9);
    EXPECT_EQ(image.height, 25);
    const float largest = grid->tree().getValue(Coord(4, 8, 9));
    for (int y = 0; y < 25; ++y) {
        const Coord voxel(3, 4, 9 - int((y + 0.5) / 2.5));
        EXPECT_EQ(image.at(8 + kGap + 3, y)[0], linearFromSrgb(grid->tree().getValue(voxel) / largest)) << y;
    }
    grid->transform().preScale(openvdb::Vec3d(1, 1, 1e9));
    EXPECT_EQ(middleSlices(*grid, dims).height, 160) << "the picture stays one";
}

TEST(MiddleSlices, OfNothingAreBlack) {
    const Image image = middleSlices(*FloatGrid::create(0), Index3(8, 8, 8));
    for (const float value : image.pixels) EXPECT_EQ(value, 0);
    EXPECT_THROW(middleSlices(*FloatGrid::create(0), Index3(8, 0, 8)), InvalidArgument);
}
