#include "raysweep/phantoms/ct_phantoms.h"

#include "raysweep/core/error.h"
#include "support/volumes.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

/// Sum over the shapes of density and volume: also where they overlap.
double analyticMass(const std::vector<SolidShape>& shapes) {
    double mass = 0;
    for (const SolidShape& shape : shapes) {
        const double product = shape.halfAxes[0].length() * shape.halfAxes[1].length() * shape.halfAxes[2].length();
        const double unit = shape.kind == SolidShape::Kind::ellipsoid ? 4 * kPi / 3
                            : shape.kind == SolidShape::Kind::box     ? 8
                                                                      : 2 * kPi;
        mass += shape.density * unit * product;
    }
    return mass;
}

}  // namespace

TEST(CtPhantoms, HeadHasItsDensitiesAndIsNowhereNegative) {
    const std::vector<SolidShape> modified = sheppLogan(), original = sheppLogan(1, HeadContrast::original);
    EXPECT_EQ(modified.size(), 10u);
    EXPECT_NEAR(densityAt(modified, Vec3(0, 0.9, 0)), 1, 1e-12) << "skull";
    EXPECT_NEAR(densityAt(modified, Vec3(0, -0.4, 0)), 0.2, 1e-12) << "brain";
    EXPECT_NEAR(densityAt(modified, Vec3(0.22, 0, -0.25)), 0, 1e-12) << "ventricle";
    EXPECT_NEAR(densityAt(original, Vec3(0, 0.9, 0)), 2, 1e-12);
    EXPECT_NEAR(densityAt(original, Vec3(0, -0.4, 0)), 1.02, 1e-12);
    EXPECT_NEAR(densityAt(original, Vec3(0, 0.35, -0.25)), 1.04, 1e-12);
    EXPECT_EQ(densityAt(modified, Vec3(0, 0.95, 0)), 0) << "outside";
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int n = 0; n < 100000; ++n) {
        const Vec3 p(uniform(random), uniform(random), uniform(random));
        ASSERT_GE(densityAt(modified, p), -1e-12);
        ASSERT_LE(densityAt(modified, p), 1 + 1e-12);
        ASSERT_GE(densityAt(original, p), -1e-12);
    }
}

// Holes that overlapped, or reached out of the box, would leave densities other than these.
TEST(CtPhantoms, BoxHasHolesThatDoNotMeet) {
    for (const Vec3& half : {Vec3(1), Vec3(128, 128, 55), Vec3(1, 3, 2)}) {
        const std::vector<SolidShape> shapes = boxWithHoles(half);
        std::mt19937 random(4);
        std::uniform_real_distribution<double> uniform(-1, 1);
        for (int n = 0; n < 200000; ++n) {
            const double density = densityAt(shapes, Vec3(uniform(random), uniform(random), uniform(random)) * half);
            ASSERT_TRUE(density == 0 || density == 0.5 || density == 1) << density;
        }
        EXPECT_EQ(densityAt(shapes, half * 0.6), 1);
        EXPECT_EQ(densityAt(shapes, half * 0.65), 0);
        EXPECT_EQ(densityAt(shapes, Vec3(-0.375, -0.375, 0.2) * half), 0) << "a hole along z";
    }
}

TEST(CtPhantoms, GridsHoldTheMassOfTheirShapes) {
    PhantomOptions options;
    options.size = 96;
    options.density = 0.5f;
    // Of the surfaces' voxels each is known to 1/256 or, where a face runs along the lines, to 1/16.
    EXPECT_NEAR(test::massOf(*makeSheppLogan(options)) / analyticMass(sheppLogan(options)), 1, 2e-4);
    EXPECT_NEAR(test::massOf(*makeBoxWithHoles(options)) / analyticMass(boxWithHoles(options)), 1, 1e-3);
    options.dims = Coord(96, 80, 41);
    options.voxelSize = 2;
    const FloatGrid::Ptr grid = makeBoxWithHoles(options);
    EXPECT_NEAR(test::massOf(*grid) / analyticMass(boxWithHoles(options)), 1, 5e-3);
    EXPECT_NEAR(grid->indexToWorld(openvdb::Vec3d(47.5, 39.5, 20)).length(), 0, 1e-12);
    const Coord extent = grid->evalActiveVoxelBoundingBox().dim();
    EXPECT_EQ(extent, Coord(60, 50, 27)) << "five eighths of each dimension, rounded up to whole voxels";
    options.dims[0] = -3;
    EXPECT_THROW(makeBoxWithHoles(options), InvalidArgument);
}

TEST(CtPhantoms, DensityAndVoxelSizeAreWhatWasAskedFor) {
    PhantomOptions options;
    options.size = 64;
    options.density = 3;
    options.voxelSize = 0.25;
    const FloatGrid::Ptr grid = makeSheppLogan(options);
    float largest = 0;
    for (auto it = grid->cbeginValueOn(); it; ++it) test::raiseTo(largest, *it);
    EXPECT_NEAR(largest, 3, 1e-6);
    EXPECT_EQ(grid->transform().voxelSize()[0], 0.25);
    EXPECT_EQ(grid->getName(), "density");
    const openvdb::CoordBBox bounds = grid->evalActiveVoxelBoundingBox();
    EXPECT_EQ(bounds.dim().y(), 60) << "0.92 of 64 voxels, rounded up to whole ones on both sides";
    EXPECT_EQ(bounds.min().y(), 2);
}
