#include "raysweep/reconstruct/photo_sheets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "raysweep/phantoms/triangles.h"
#include "raysweep/reconstruct/photo_step.h"

using namespace raysweep;

namespace {

constexpr int kEdge = 24;  ///< voxels

/// A sheet one voxel thick across the normal, with partial coverage of voxels.
struct Sheet {
    CompositeLayout layout;
    std::vector<CompositeVoxel> voxels;

    explicit Sheet(const Vec3& normal) {
        const Vec3 u = normal.cross(Vec3(0.3, -0.5, 0.8)).normalized(), v = normal.cross(u);
        TranslucentTriangle triangle;
        triangle.opacity = 0.6;
        triangle.color = grey(1);
        triangle.corners[0] = u * 9.0;
        triangle.corners[1] = u * -5.0 + v * 8.0;
        triangle.corners[2] = u * -5.0 - v * 8.0;
        TrianglesOptions options;
        options.size = kEdge;
        options.voxelSize = 1;
        const ColorVolume volume = voxelizeTriangles({triangle}, options);
        std::vector<MaskedBrick> bricks;
        for (auto leaf = volume.density->tree().cbeginLeaf(); leaf; ++leaf) {
            MaskedBrick brick{Index3(leaf->origin().x(), leaf->origin().y(), leaf->origin().z()), {}};
            brick.mask.fill(~std::uint64_t(0));
            bricks.push_back(brick);
        }
        layout = compositeLayout(Index3(kEdge), bricks);
        voxels.resize(layout.voxelCount());
        for (auto value = volume.density->cbeginValueOn(); value; ++value) {
            const openvdb::Coord at = value.getCoord();
            voxels[layout.voxel(Index3(at.x(), at.y(), at.z()))].extinction = *value;
        }
    }

    Vec3 place(std::size_t i) const {
        const Index3& origin = layout.origins[i >> 9];
        return Vec3(origin.x + int(i >> 6 & 7), origin.y + int(i >> 3 & 7), origin.z + int(i & 7)) -
               Vec3(0.5 * (kEdge - 1));
    }
};

/// Root of the mean square of sines between directions, either sign, and the normal, weighted by extinction.
template <class Direction>
double rmsSine(const Sheet& sheet, const Vec3& normal, const Direction& direction) {
    double sum = 0, weight = 0;
    for (std::size_t i = 512; i < sheet.voxels.size(); ++i) {
        const float w = sheet.voxels[i].extinction;
        if (!(w > 0) || sheet.place(i).length() > 4) continue;  // its edges face elsewhere
        sum += w * direction(i).cross(normal).length2();
        weight += w;
    }
    return std::sqrt(sum / weight);
}

}  // namespace

TEST(PhotoSheets, AxesAreThoseOfThinSheets) {
    double axes = 0, gradients = 0;
    for (const Vec3& aslant : {Vec3(1, 0.3, 0.2), Vec3(0.5, -0.8, 0.4), Vec3(-0.6, 0.6, 0.7)}) {
        const Vec3 normal = aslant.normalized();
        const Sheet sheet(normal);
        const std::vector<SheetNormal> found = sheetNormals(sheet.layout, sheet.voxels);
        std::vector<PackedNormal> packed(sheet.voxels.size());
        for (std::size_t b = 1; b < sheet.layout.brickCount(); ++b)
            brickNormals(sheet.layout, sheet.voxels.data(), b, &packed[b * 512]);
        const double axis = rmsSine(
            sheet, normal, [&](std::size_t i) { return Vec3(found[i].axis[0], found[i].axis[1], found[i].axis[2]); });
        const double gradient = rmsSine(
            sheet, normal, [&](std::size_t i) { return Vec3(packed[i].x, packed[i].y, packed[i].z).normalized(); });
        axes = std::max(axes, axis);
        gradients = std::max(gradients, gradient);
        for (std::size_t i = 512; i < sheet.voxels.size(); ++i) {
            const double along = sheet.place(i).dot(normal);
            const Vec3 n(found[i].axis[0], found[i].axis[1], found[i].axis[2]);
            if (sheet.place(i).length() > 4 || std::abs(along) < 0.8 || !(sheet.voxels[i].extinction > 0)) continue;
            EXPECT_GT(found[i].side * n.dot(normal) * along, 0);
        }
    }
    EXPECT_LT(axes, 0.47);  // found .431: central differences of a sheet of one voxel favour the cube's diagonals
    EXPECT_GT(gradients, 1.1 * axes);  // found .490
}

TEST(PhotoSheets, BrightnessChangesAsItsDerivativesSay) {
    const SheetNormal n{{0.6f, 0.0f, 0.8f}, -0.4f};
    SheetLight light{0.3f, 0.7f, {0.36f, 0.48f, 0.8f}, {0, 1, 0}};
    for (const float sign : {1.0f, -1.0f}) {
        for (float& component : light.toLight) component *= sign;
        light.toCamera[2] = 0.5f * sign;
        const SheetBrightness at(n, light);
        constexpr float kStep = 0.01f;  // eq. 1 is linear but for the change of sign: any step, but for rounding
        const auto after = [&](auto&& change) {
            SheetLight other = light;
            change(other);
            return (SheetBrightness(n, other).all - at.all) / kStep;
        };
        EXPECT_NEAR(after([](SheetLight& l) { l.ambient += kStep; }), 1, 2e-5);
        EXPECT_NEAR(after([](SheetLight& l) { l.diffuse += kStep; }), at.diffuse, 2e-5);
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(after([&](SheetLight& l) { l.toLight[i] += kStep; }), at.along * n.axis[i], 2e-5);
    }
}

TEST(PhotoSheets, OneSideIsLambertsLaw) {
    const SheetNormal n{{0, 0, 1}, 1};
    SheetLight light{0.25f, 0.75f, {0.6f, 0, 0.8f}, {1, 0, 0}};  // seen from beside
    EXPECT_FLOAT_EQ(SheetBrightness(n, light).all, 0.25f + 0.75f * 0.8f);
    light.toLight[2] = -0.8f;
    EXPECT_FLOAT_EQ(SheetBrightness(n, light).all, 0.25f);
}
