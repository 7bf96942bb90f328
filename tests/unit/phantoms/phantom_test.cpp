#include "raysweep/phantoms/phantom.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/types.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

double worldIntegral(const FloatGrid& grid) {
    double sum = 0;
    for (auto it = grid.cbeginValueOn(); it; ++it) sum += *it;
    return sum * grid.transform().voxelSize().product();
}

PhantomOptions withSize(int size) {
    PhantomOptions options;
    options.size = size;
    return options;
}

}  // namespace

TEST(Phantom, SphereHasTheVolumeOfABall) {
    for (const double soft : {0.0, 1.0, 4.0, 16.0}) {
        PhantomOptions options = withSize(96);
        options.soft = soft;
        const FloatGrid::Ptr grid = makeSphere(options);
        // A density that falls linearly from R - s/2 to R + s/2 integrates to 4/3 pi (R^3 + R s^2/4).
        const double h = 2.0 / 96, R = 0.5 * (96 - soft) * h, s = soft * h;
        const double expected = 4.0 / 3 * kPi * (R * R * R + R * s * s / 4);
        // A hard edge is counted by voxel centres: the error of a lattice count falls with the number of voxels on
        // the surface, about 1e-3 here. A soft edge is integrated smoothly.
        EXPECT_NEAR(worldIntegral(*grid) / expected, 1, soft == 0 ? 3e-3 : 3e-4) << "soft " << soft;
    }
}

TEST(Phantom, SphereIsCentredAndTouchesItsBox) {
    for (const int size : {33, 64}) {
        PhantomOptions options = withSize(size);
        options.soft = 0;
        const FloatGrid::Ptr grid = makeSphere(options);
        EXPECT_EQ(grid->evalActiveVoxelBoundingBox(), openvdb::CoordBBox(Coord(0), Coord(size - 1)));
        const openvdb::Vec3d middle = grid->indexToWorld(openvdb::Vec3d(0.5 * (size - 1)));
        EXPECT_NEAR(middle.length(), 0, 1e-12);
        EXPECT_EQ(grid->getName(), "density");
        EXPECT_EQ(grid->getGridClass(), openvdb::GRID_FOG_VOLUME);
    }
}

TEST(Phantom, BoxFillsItsVoxels) {
    PhantomOptions options;
    options.dims = Coord(40, 20, 10);
    options.density = 0.5f;
    const FloatGrid::Ptr grid = makeBox(options);
    EXPECT_EQ(grid->activeVoxelCount(), 40u * 20 * 10);
    EXPECT_NEAR(worldIntegral(*grid), 0.5 * 2 * 1 * 0.5, 1e-9);
    options.voxelSize = 0.1;
    EXPECT_NEAR(worldIntegral(*makeBox(options)), 0.5 * 4 * 2 * 1, 1e-6);
}

TEST(Phantom, CloudHasTheSizeThatWasAskedFor) {
    for (const int size : {64, 128}) {
        const FloatGrid::Ptr grid = makeCloud(withSize(size));
        const Coord dim = grid->evalActiveVoxelBoundingBox().dim();
        const int longest = std::max({dim.x(), dim.y(), dim.z()});
        EXPECT_GE(longest, size * 0.95);
        EXPECT_LE(longest, size + 2);
        const double filled = double(grid->activeVoxelCount()) / (double(dim.x()) * dim.y() * dim.z());
        EXPECT_GT(filled, 0.1);
        EXPECT_LT(filled, 0.6) << "a cloud is not a box";
    }
}

// Whatever is cut off ends in a wall: full density next to nothing. Soft edges have only thin voxels there.
TEST(Phantom, CloudIsNotCutByItsBox) {
    for (const unsigned seed : {1u, 2u, 3u}) {
        PhantomOptions options = withSize(128);
        options.seed = seed;
        const FloatGrid::Ptr grid = makeCloud(options);
        const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
        float atFaces = 0, largest = 0;
        for (auto it = grid->cbeginValueOn(); it; ++it) {
            test::raiseTo(largest, *it);
            const Coord c = it.getCoord();
            for (int axis = 0; axis < 3; ++axis)
                if (c[axis] == box.min()[axis] || c[axis] == box.max()[axis]) atFaces = std::max(atFaces, *it);
        }
        EXPECT_LT(atFaces, 0.35) << "seed " << seed;
        EXPECT_GT(largest, 0.9);
        EXPECT_LE(largest, 1.0);
    }
}

TEST(Phantom, CloudHasTheSameBitsForAnyNumberOfThreadsAndChangesWithTheSeed) {
    FloatGrid::Ptr grids[2];
    for (int threads = 1; threads <= 2; ++threads) {
        const ThreadLimit limit(threads);
        grids[threads - 1] = makeCloud(withSize(48));
    }
    EXPECT_TRUE(grids[0]->tree().hasSameTopology(grids[1]->tree()));
    for (auto it = grids[0]->cbeginValueOn(); it; ++it) ASSERT_EQ(*it, grids[1]->tree().getValue(it.getCoord()));
    PhantomOptions other = withSize(48);
    other.seed = 7;
    EXPECT_FALSE(makeCloud(other)->tree().hasSameTopology(grids[0]->tree()));
}

TEST(Phantom, OptionsOutOfRangeAreRefused) {
    PhantomOptions options = withSize(1);
    EXPECT_THROW(makeSphere(options), InvalidArgument);
    options = withSize(32);
    options.soft = 17;
    EXPECT_THROW(makeSphere(options), InvalidArgument);
    options = withSize(32);
    options.density = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(makeBox(options), InvalidArgument);
}
