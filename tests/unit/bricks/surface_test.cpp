#include "raysweep/bricks/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "raysweep/bricks/brick_map.h"
#include "raysweep/bricks/gradient.h"

using namespace raysweep;

namespace {

/// 2x2x2 bricks with corner at (-8,-8,-8), and a field over them.
struct Block {
    template <class Value>
    explicit Block(const Value& value) {
        for (int x = -8; x <= 0; x += 8)
            for (int y = -8; y <= 0; y += 8)
                for (int z = -8; z <= 0; z += 8) layout.origins.emplace_back(x, y, z);
        layout.low = Index3(-8);
        layout.high = Index3(8);
        field = BrickField(layout.brickCount());
        for (std::size_t b = 0; b < layout.brickCount(); ++b)
            for (int i = 0; i < kBrickVoxels; ++i)
                field.brick(b)[i] = float(value(layout.origins[b] + Index3(i >> 6, (i >> 3) & 7, i & 7)));
    }

    BrickLayout layout;
    BrickField field;
};

Surfaces surfacesOf(const Block& block) {
    return findSurfaces(block.layout, BrickMap(block.layout), block.field, {}, {1, 0.1});
}

/// Depth of a voxel of that opacity.
double depthOf(double opacity) {
    return -std::log1p(-opacity);
}

}  // namespace

TEST(SurfaceVoxels, PackedNormalsKeepTheirDirection) {
    for (int i = 0; i < 1000; ++i) {
        const double z = 1 - (i + 0.5) / 500, r = std::sqrt(1 - z * z);
        const Vec3 normal(r * std::cos(2.4 * i), r * std::sin(2.4 * i), z);
        EXPECT_NE(packNormal(normal), 0u);
        EXPECT_LE((unpackNormal(packNormal(normal)) - normal).length(), 0.0017);  // half a step along each axis
    }
}

TEST(SurfaceVoxels, GradientOfALinearFieldIsExactAcrossBricks) {
    const Vec3 slope(0.5, -0.25, 2);
    const Block block([&](const Index3& v) { return 100 + slope.dot(Vec3(v)); });
    const BrickMap map(block.layout);
    for (std::size_t b = 0; b < block.layout.brickCount(); ++b) {
        const PaddedBrick<float> padded(block.layout, map, Periodic{}, b,
                                        [&](std::size_t n) { return block.field.brick(n); });
        const Index3 inner(block.layout.origins[b].x < 0 ? 7 : 0, block.layout.origins[b].y < 0 ? 7 : 0,
                           block.layout.origins[b].z < 0 ? 7 : 0);  // the corner where all bricks meet
        EXPECT_LE((gradientAt(padded, inner.x, inner.y, inner.z) - slope).length(), 1e-5);
    }
}

TEST(SurfaceVoxels, OnlyTheLayersAtTheFaceOfASolidAreSurface) {
    const Block block([](const Index3& v) { return v.z < 0 ? 4.6 : 0.0; });
    const Surfaces surfaces =
        findSurfaces(block.layout, BrickMap(block.layout), block.field, {true, true, false}, {1, 0.1});
    // Two layers, where opacity averaged over five voxels changes, at the upper face and, since outside of all bricks
    // is empty, at the lower one. What is between them is inside.
    EXPECT_EQ(countSurfaceVoxels(surfaces), 4u * 16 * 16);
    EXPECT_FALSE(surfaces.mixed);
    EXPECT_TRUE(surfaces.isInside(BrickMap(block.layout).find({3, -5, -4}), int(offsetInBrick(Index3(3, -5, -4)))));
    const BrickMap map(block.layout);
    for (const auto& [voxel, up] : {std::pair(Index3(3, -5, -1), 1.0), std::pair(Index3(3, -5, -8), -1.0)}) {
        const PackedNormal* const normals = surfaces.normals(map.find(voxel));
        ASSERT_NE(normals, nullptr);
        EXPECT_LE((unpackNormal(normals[offsetInBrick(voxel)]) - Vec3(0, 0, up)).length(), 1e-6);
    }
}

TEST(SurfaceVoxels, NormalsAreWorldVectors) {
    Block block([](const Index3& v) { return v.x + v.z < 0 ? 4.6 : 0.0; });
    block.layout.worldFromIndex = Matrix3(1, 0, 0, 0, 1, 0, 0, 0, 3);  // z is stretched: the face leans towards x
    block.layout.voxelVolume = 3;
    const Surfaces surfaces = findSurfaces(block.layout, BrickMap(block.layout), block.field, {}, {1, 0.1});
    const Index3 voxel(0, 0, -1);
    const PackedNormal* const normals = surfaces.normals(BrickMap(block.layout).find(voxel));
    ASSERT_NE(normals, nullptr);
    const Vec3 exact = Vec3(3, 0, 1).normalized();
    EXPECT_LE((unpackNormal(normals[offsetInBrick(voxel)]) - exact).length(), 0.003);
}

// Slices of scans are several times as far apart as pixels.
TEST(SurfaceVoxels, AFaceAcrossLongVoxelsIsASurface) {
    for (const double length : {0.2, 6.0, 10.0}) {
        Block block([](const Index3& v) { return v.z < 0 ? 4.6 : 0.0; });
        block.layout.worldFromIndex = Matrix3(1, 0, 0, 0, 1, 0, 0, 0, length);
        block.layout.voxelVolume = length;
        const Surfaces surfaces =
            findSurfaces(block.layout, BrickMap(block.layout), block.field, {true, true, false}, {1, 0.1});
        EXPECT_EQ(countSurfaceVoxels(surfaces), 4u * 16 * 16) << length;
        EXPECT_FALSE(surfaces.mixed);
    }
}

// Mirrored (as files of RAS places are), with axes that change places, turned, and both: the same voxels, their normals
// turned.
TEST(SurfaceVoxels, TheWayThatTheGridLiesChangesNothing) {
    const auto ball = [](const Index3& v) {
        return 4.6 * std::clamp(6.5 - (Vec3(v) - Vec3(-0.3, 0.1, -0.4)).length(), 0.0, 1.0);
    };
    // Depth enough behind each face, and a gap that is too narrow for the local furnace.
    const auto gap = [](const Index3& v) { return v.x + v.y == 1 ? 0.0 : 4.6; };
    const double s = std::sqrt(0.5);
    Block straight(ball), narrow(gap);
    const Surfaces expected = surfacesOf(straight), mixed = surfacesOf(narrow);
    ASSERT_GT(countSurfaceVoxels(expected), 500u);
    ASSERT_FALSE(expected.mixed);
    ASSERT_TRUE(mixed.mixed);
    for (const Matrix3& turn : {Matrix3(-1, 0, 0, 0, -1, 0, 0, 0, 1), Matrix3(0, 1, 0, 0, 0, 1, 1, 0, 0),
                                Matrix3(s, s, 0, -s, s, 0, 0, 0, 1), Matrix3(-s, 0, s, 0, -1, 0, s, 0, s)}) {
        straight.layout.worldFromIndex = narrow.layout.worldFromIndex = turn;
        const Surfaces turned = surfacesOf(straight);
        EXPECT_EQ(countSurfaceVoxels(turned), countSurfaceVoxels(expected));
        EXPECT_FALSE(turned.mixed);
        EXPECT_TRUE(surfacesOf(narrow).mixed);
        for (std::size_t b = 0; b < straight.layout.brickCount(); ++b)
            for (int i = 0; i < kBrickVoxels; ++i) {
                const PackedNormal before = expected.normals(b)[i], after = turned.normals(b)[i];
                ASSERT_EQ(isSurface(before), isSurface(after));
                if (!isSurface(before)) continue;
                // As exact as packed normals are.
                EXPECT_LE((unpackNormal(before) * turn - unpackNormal(after)).length(), 0.003);
            }
    }
}

// The normals that Lambert's law is applied to: a sphere as levelSetToSolid makes it, its edge one voxel soft.
TEST(SurfaceVoxels, NormalsOfASphereAreThoseOfTheSphere) {
    const Vec3 middle(-0.3, 0.1, -0.4);
    const Block block([&](const Index3& v) {
        const double distance = (Vec3(v) - middle).length() - 6;
        return depthOf(0.99 * std::clamp(0.5 - distance, 0.0, 1.0));
    });
    const Surfaces surfaces = surfacesOf(block);
    EXPECT_FALSE(surfaces.mixed);
    double sum = 0, count = 0;
    for (std::size_t b = 0; b < block.layout.brickCount(); ++b)
        for (int i = 0; i < kBrickVoxels; ++i) {
            if (!isSurface(surfaces.normals(b)[i])) continue;
            const Vec3 out = (Vec3(block.layout.origins[b] + voxelInBrick(i)) - middle).normalized();
            sum += std::acos(std::min(1.0, out.dot(unpackNormal(surfaces.normals(b)[i])))) * 180 / kPi;
            ++count;
        }
    std::printf("  normals %.3f degrees off on average\n", sum / count);
    EXPECT_LE(sum / count, 0.95);
}

// Light goes through them: they are media, and so is noise, whose gradients mean nothing.
TEST(SurfaceVoxels, SoftAndNoisySolidsHaveNone) {
    const auto plate = [](double opacity, double noise) {
        std::mt19937 random(3);
        return surfacesOf(Block([&](const Index3& v) {
            const double a = opacity + noise * std::normal_distribution<double>()(random);
            return std::abs(v.z) < 4 ? depthOf(std::clamp(a, 0.0, 0.99)) : 0.0;
        }));
    };
    for (const double noise : {0.0, 0.05, 0.15}) {
        const Surfaces surfaces = plate(0.35, noise);
        EXPECT_EQ(countSurfaceVoxels(surfaces), 0u) << noise;
    }
    EXPECT_GT(countSurfaceVoxels(plate(0.95, 0.02)), 0u);
    std::mt19937 random(4);
    const Surfaces grains =
        surfacesOf(Block([&](const Index3&) { return random() % 2 ? depthOf(0.99) : 0.0; }));  // 4096 of them
    EXPECT_LE(countSurfaceVoxels(grains), 100u);
    EXPECT_TRUE(grains.mixed);
}

TEST(SurfaceVoxels, ASheetOneVoxelThickIsAMedium) {
    const Surfaces surfaces = surfacesOf(Block([](const Index3& v) { return v.z == 2 ? 4.6 : 0.0; }));
    EXPECT_EQ(countSurfaceVoxels(surfaces), 0u);
    EXPECT_TRUE(surfaces.inside.empty());
}
