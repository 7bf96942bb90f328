#include "raysweep/volume/classify.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

namespace {

/// Values 0, 0.1, 0.2 ... along x, in voxels that are boxes of volume 0.5.
FloatGrid::Ptr steps(int count) {
    auto grid = FloatGrid::create();
    grid->setName("density");
    for (int i = 0; i < count; ++i) grid->tree().setValueOn({i, 0, 0}, 0.1f * float(i));
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preScale(openvdb::Vec3d(-0.5, 1, 1));  // mirrored: its determinant is negative
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    return grid;
}

}  // namespace

TEST(Classify, OpticalDepthOfAVoxelIsMinusLogOfItsTransparency) {
    const auto density = steps(12);
    const double edge = std::cbrt(0.5);
    const ClassifiedVolume volume = classify(*density, rampFunction(0.2, 1, 0.99));
    EXPECT_EQ(volume.extinction->getName(), "extinction");
    EXPECT_EQ(volume.extinction->transform(), density->transform());
    EXPECT_EQ(volume.extinction->background(), 0);
    EXPECT_FALSE(volume.albedo);
    for (int i = 0; i < 12; ++i) {
        const double value = double(density->tree().getValue({i, 0, 0}));
        const double opacity = std::min(0.99, std::max(0.0, 0.99 * (value - double(0.2f)) / (1 - double(0.2f))));
        const double depth = double(volume.extinction->tree().getValue({i, 0, 0})) * edge;
        EXPECT_NEAR(depth, -std::log(1 - opacity), 1e-6 * depth) << i;  // floats are stored
        EXPECT_EQ(volume.extinction->tree().isValueOn({i, 0, 0}), depth > 0) << i;
    }
    // 0.3 and above: the float 0.2 is a little above the double, and still at the ramp's foot.
    EXPECT_EQ(volume.extinction->activeVoxelCount(), 9u);
}

TEST(Classify, CapsTheOpacity) {
    const ClassifiedVolume volume = classify(*steps(12), rampFunction(0, 1, 1));
    const double edge = std::cbrt(0.5), deepest = double(volume.extinction->tree().getValue({11, 0, 0})) * edge;
    EXPECT_NEAR(deepest, -std::log(1 - kMostOpaque), 1e-5);
}

TEST(Classify, ColoursBecomeAlbedo) {
    const TransferFunction colours{{{0, 0, Color(1, 0, 0)}, {1, 1, Color(0, 0.5f, 1)}}, true};
    const ClassifiedVolume volume = classify(*steps(8), colours);
    const auto albedo = openvdb::gridPtrCast<Vec3SGrid>(volume.albedo);
    ASSERT_TRUE(albedo);
    EXPECT_EQ(albedo->transform(), volume.extinction->transform());
    EXPECT_EQ(albedo->activeVoxelCount(), volume.extinction->activeVoxelCount());
    for (int i = 1; i < 8; ++i) {
        const float t = 0.1f * float(i);
        EXPECT_LT((albedo->tree().getValue({i, 0, 0}) - Vec3s(1 - t, 0.5f * t, t)).length(), 1e-6f) << i;
    }
    EXPECT_EQ(albedo->tree().getValue({0, 0, 0}), Vec3s(0));  // nothing there to scatter

    const TransferFunction greys{{{0, 0, grey(0.25f)}, {1, 1, grey(0.75f)}}, true};
    const auto grey = openvdb::gridPtrCast<FloatGrid>(classify(*steps(8), greys).albedo);
    ASSERT_TRUE(grey);
    EXPECT_NEAR(grey->tree().getValue({4, 0, 0}), 0.45f, 1e-6f);
}

TEST(Classify, TilesAreClassifiedAsTheirVoxels) {
    auto tiles = FloatGrid::create();
    tiles->tree().addTile(1, Coord(0), 0.5f, true);  // 8^3
    tiles->tree().addTile(1, Coord(8, 0, 0), 0.1f, true);
    tiles->tree().addTile(2, Coord(128, 0, 0), 0.7f, true);  // 128^3
    tiles->tree().setValueOn({16, 0, 0}, 0.6f);
    auto voxels = tiles->deepCopy();
    voxels->tree().voxelizeActiveTiles();
    ASSERT_NE(voxels->tree().leafCount(), tiles->tree().leafCount());
    const TransferFunction table{{{0.2, 0, Color(1, 0, 0)}, {1, 1, Color(0, 0.5f, 1)}}, true};
    const ClassifiedVolume one = classify(*tiles, table), other = classify(*voxels, table);
    EXPECT_EQ(one.extinction->activeVoxelCount(), 8u * 8 * 8 + 128u * 128 * 128 + 1);
    EXPECT_TRUE(sameBits(*one.extinction, *other.extinction));
    EXPECT_TRUE(sameBits(*one.albedo, *other.albedo));
    // What is uniform is a tile again, whatever it came from.
    EXPECT_EQ(one.extinction->tree().leafCount(), 1u);
    EXPECT_EQ(other.extinction->tree().leafCount(), 1u);
}

TEST(Classify, EqualOpacitiesKeepTheirColours) {
    auto density = FloatGrid::create();
    for (int i = 0; i < 512; ++i)
        density->tree().setValueOn(Coord(i >> 6, (i >> 3) & 7, i & 7), 0.5f + float(i) / 1024);
    const TransferFunction table{{{0.5, 0.9, Color(1, 0, 0)}, {1, 0.9, Color(0, 0, 1)}}, true};
    const ClassifiedVolume volume = classify(*density, table);
    EXPECT_EQ(volume.extinction->tree().leafCount(), 0u) << "one opacity is one tile";
    const auto& albedo = static_cast<const openvdb::Vec3SGrid&>(*volume.albedo);
    EXPECT_LE(std::abs(albedo.tree().getValue(Coord(0))[0] - 1), 1e-6);
    EXPECT_LE(std::abs(albedo.tree().getValue(Coord(7))[2] - 511.0 / 512), 1e-6);
}

TEST(Classify, InactiveVoxelsStayEmpty) {
    const auto density = steps(8);
    density->tree().setValueOff({3, 0, 0}, 0.9f);
    density->tree().root().setBackground(0.9f, /*updateChildNodes=*/true);
    const ClassifiedVolume volume = classify(*density, rampFunction(-1, 1));
    EXPECT_EQ(volume.extinction->activeVoxelCount(), 7u);
    EXPECT_EQ(volume.extinction->tree().getValue({3, 0, 0}), 0);
    EXPECT_EQ(volume.extinction->background(), 0);
}

TEST(Classify, RefusesValuesThatAreNotFiniteButTakesNegativeOnes) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()}) {
        const auto density = steps(8);
        density->tree().setValueOn({5, 0, 0}, bad);
        try {
            classify(*density, rampFunction(0, 1));
            FAIL() << bad;
        } catch (const InvalidArgument& e) {
            EXPECT_NE(std::string(e.what()).find("index (5, 0, 0)"), std::string::npos) << e.what();
        }
    }
    const auto density = steps(8);
    density->tree().setValueOn({0, 0, 0}, -1000);
    EXPECT_EQ(classify(*density, rampFunction(-2000, 0)).extinction->activeVoxelCount(), 8u);
    EXPECT_THROW(classify(*density, TransferFunction()), InvalidArgument);
}
