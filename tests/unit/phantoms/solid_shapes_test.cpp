#include "raysweep/phantoms/solid_shapes.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "support/volumes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

Vec3 randomDirection(std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (;;) {
        const Vec3 v(uniform(random), uniform(random), uniform(random));
        if (v.length2() < 1 && v.length2() > 0.01) return v.normalized();
    }
}

/// One shape of each kind, overlapping, in [-1,1]³.
std::vector<SolidShape> someShapes() {
    return {box(1, Vec3(0.1, 0, -0.1), Vec3(0.7, 0.5, 0.6)),
            ellipsoid(0.5, Vec3(-0.1, 0.2, 0), Vec3(0.6, 0.3, 0.4), 30), cylinder(-0.8, Vec3(0.2, 0, 0.1), 0, 0.3, 0.5),
            cylinder(0.3, Vec3(0, -0.2, 0), 1, 0.2, 0.7), cylinder(0.7, Vec3(0, 0.3, 0), 2, 0.25, 0.8)};
}

}  // namespace

// Chord of an ellipse at distance t from its centre: 2 a b sqrt(s² - t²)/s², s² = a² cos²(theta') + b² sin²(theta'),
// theta' the angle from the axis a to the detector's axis.
TEST(SolidShapes, ChordOfATurnedEllipsoidIsTheClosedForm) {
    const double a = 0.7, b = 0.3, turn = 25, density = 1.5;
    const std::vector<SolidShape> shapes{ellipsoid(density, Vec3(0.1, -0.2, 0), Vec3(a, b, 0.5), turn)};
    for (const double theta : {0.0, 40.0, 90.0, 200.0})
        for (const double t : {-0.35, 0.0, 0.1, 0.29}) {
            const double angle = theta * kPi / 180, relative = (theta - turn) * kPi / 180;
            const Vec3 across(std::cos(angle), std::sin(angle), 0), along(-across.y, across.x, 0);
            const double s2 = std::pow(a * std::cos(relative), 2) + std::pow(b * std::sin(relative), 2);
            const double expected = t * t < s2 ? 2 * density * a * b * std::sqrt(s2 - t * t) / s2 : 0;
            const Vec3 origin = Vec3(0.1, -0.2, 0) + across * t - along * 1e4;
            // A source 1e4 half axes away leaves 1e-16 * 1e4 of the position, and its root near the rim.
            EXPECT_NEAR(lineIntegral(shapes, origin, along), expected, 1e-10) << "theta " << theta << " t " << t;
        }
}

TEST(SolidShapes, LineIntegralsAreTheSumOfDensitiesAlongTheLine) {
    std::mt19937 random(1);
    const std::vector<SolidShape> shapes = someShapes();
    const int steps = 20000;
    for (int trial = 0; trial < 40; ++trial) {
        const Vec3 direction = randomDirection(random), origin = randomDirection(random) * 0.5;
        const double from = trial % 2 ? -0.2 : -3, to = trial % 3 ? 3 : 0.3, step = (to - from) / steps;
        double sum = 0;
        for (int n = 0; n < steps; ++n) sum += densityAt(shapes, origin + direction * (from + (n + 0.5) * step));
        // Each of up to ten crossings is found to within half a step.
        EXPECT_NEAR(lineIntegral(shapes, origin, direction, from, to), sum * step, 5 * step) << "trial " << trial;
    }
}

TEST(SolidShapes, LinesAlongTheAxesMeetFlatAndRoundSides) {
    const std::vector<SolidShape> block{box(2, Vec3(0), Vec3(1, 2, 3))};
    EXPECT_NEAR(lineIntegral(block, Vec3(0.5, 1.9, -9), Vec3(0, 0, 1)), 12, 1e-12);
    EXPECT_EQ(lineIntegral(block, Vec3(1.5, 0, -9), Vec3(0, 0, 1)), 0);
    EXPECT_NEAR(lineIntegral(block, Vec3(0, 0, 1), Vec3(0, 0, 1), 0), 4, 1e-12) << "from a source within";
    const std::vector<SolidShape> rod{cylinder(1, Vec3(0), 1, 0.5, 2)};
    EXPECT_NEAR(lineIntegral(rod, Vec3(0.3, 7, 0), Vec3(0, -1, 0)), 4, 1e-12);
    EXPECT_NEAR(lineIntegral(rod, Vec3(0.3, 1, 7), Vec3(0, 0, -1)), 0.8, 1e-12);
    EXPECT_EQ(lineIntegral(rod, Vec3(0.6, 7, 0), Vec3(0, -1, 0)), 0);
}

TEST(SolidShapes, VoxelsHoldTheMassOfWhatTheyAreMadeFrom) {
    const Vec3 axes(0.8, 0.5, 0.6);
    const std::vector<SolidShape> ball{ellipsoid(1.5, Vec3(0.05, 0.1, -0.1), axes, 20)};
    const double mass = 1.5 * 4 / 3 * kPi * axes.x * axes.y * axes.z;
    // Lines 1/8 voxel apart: what is missed at the rims is of both signs and averages out over the surface.
    EXPECT_NEAR(test::massOf(*voxelize(ball, Coord(64), 2.0 / 64)) / mass, 1, 1e-4);
    EXPECT_NEAR(test::massOf(*voxelize(ball, Coord(50, 33, 41), 0.05)) / mass, 1, 2e-4) << "any dims";
    const std::vector<SolidShape> drilled{box(1, Vec3(0), Vec3(0.75)), cylinder(-1, Vec3(0, 0.1, 0.1), 0, 0.3, 0.75)};
    EXPECT_NEAR(test::massOf(*voxelize(drilled, Coord(64), 2.0 / 64)), 1.5 * (2.25 - kPi * 0.09), 1e-3);
}

TEST(SolidShapes, AVoxelIsTheMeanOfItsInside) {
    const FloatGrid::Ptr grid = voxelize(someShapes(), Coord(40), 0.05);
    std::mt19937 random(2);
    std::uniform_int_distribution<int> index(0, 39);
    for (int trial = 0; trial < 300; ++trial) {
        const Coord ijk(index(random), index(random), index(random));
        const openvdb::Vec3d world = grid->indexToWorld(ijk);
        double sum = 0;
        const int n = 20;
        for (int a = 0; a < n * n * n; ++a) {
            const Vec3 offset(a % n, a / n % n, a / n / n);
            sum += densityAt(someShapes(),
                             Vec3(world.x(), world.y(), world.z()) + ((offset + Vec3(0.5)) / n - Vec3(0.5)) * 0.05);
        }
        // A face along the lines is known to 1/16 of a voxel here, 1/40 there; densities below 0 are cut off.
        EXPECT_NEAR(grid->tree().getValue(ijk), std::max(0.0, sum / (n * n * n)), 0.09) << ijk;
    }
}

TEST(SolidShapes, VoxelsAreCentredSparseAndTheSameForAnyNumberOfThreads) {
    const std::vector<SolidShape> shell{box(1, Vec3(0), Vec3(0.7)), box(-1, Vec3(0), Vec3(0.6))};
    FloatGrid::Ptr grids[2];
    for (int threads = 1; threads <= 2; ++threads) {
        const ThreadLimit limit(threads);
        grids[threads - 1] = voxelize(shell, Coord(80), 2.0 / 80);
    }
    EXPECT_EQ(grids[0]->activeVoxelCount(), 56u * 56 * 56 - 48 * 48 * 48);
    EXPECT_NEAR(grids[0]->indexToWorld(openvdb::Vec3d(39.5)).length(), 0, 1e-12);
    EXPECT_TRUE(grids[0]->tree().hasSameTopology(grids[1]->tree()));
    for (auto it = grids[0]->cbeginValueOn(); it; ++it) ASSERT_EQ(*it, grids[1]->tree().getValue(it.getCoord()));
    const FloatGrid::Ptr full = voxelize({box(1, Vec3(0), Vec3(1))}, Coord(64), 2.0 / 64);
    EXPECT_EQ(full->tree().leafCount(), 0u) << "what is constant is a tile";
    EXPECT_EQ(full->activeVoxelCount(), 64u * 64 * 64);
    EXPECT_THROW(voxelize(shell, Coord(8, 0, 8), 1), InvalidArgument);
    EXPECT_THROW(voxelize(shell, Coord(8), std::nan("")), InvalidArgument);
}
