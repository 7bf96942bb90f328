// Amounts that are moved to other voxels: none is lost, and all is where it was.
#include "raysweep/volume/deposit.h"

#include "raysweep/core/parallel.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/channels.h"
#include "support/expect_error.h"
#include "support/volumes.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3SGrid;
using openvdb::math::Transform;

namespace {

/// Finer, coarser, moved, of unequal edges, turned, sheared, mirrored.
std::vector<Transform::Ptr> transforms() {
    std::vector<Transform::Ptr> all;
    for (const double edge : {0.13, 0.5, 1 / 3.0, 1.0, 1.7, 9.0}) {
        all.push_back(Transform::createLinearTransform(edge));
        all.back()->postTranslate(Vec3d(0.3, -7.1, 100));
    }
    openvdb::Mat4d unequal = openvdb::Mat4d::identity();
    unequal.preScale(Vec3d(0.4, -1, 2.3));
    all.push_back(Transform::createLinearTransform(unequal));
    for (const double edge : {0.3, 1.0, 4.0}) {
        all.push_back(Transform::createLinearTransform(edge));
        all.back()->postRotate(0.4, openvdb::math::X_AXIS);
        all.back()->postRotate(1.1, openvdb::math::Z_AXIS);
    }
    all.push_back(Transform::createLinearTransform(1));
    all.back()->postShear(0.5, openvdb::math::X_AXIS, openvdb::math::Y_AXIS);
    return all;
}

/// Half of the voxels empty, the others over six decades, and a tile.
template <class GridType>
typename GridType::Ptr fire() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto grid = GridType::create();
    grid->setTransform(Transform::createLinearTransform(0.6));
    auto accessor = grid->getAccessor();
    for (int i = 0; i < 1000; ++i) {
        const double u = uniform(random);
        typename GridType::ValueType value = openvdb::zeroVal<typename GridType::ValueType>();
        for (int c = 0; c < kChannels<decltype(value)>; ++c)
            channel(value, c) = u > 0 ? float(std::pow(10, 6 * u - 3) * (c + 1)) : 0.0f;
        accessor.setValueOn(Coord(i / 100, i / 10 % 10, i % 10), value);
    }
    grid->tree().addTile(1, Coord(-16, 8, 0), typename GridType::ValueType(0.7f), true);
    return grid;
}

/// Amount and first moment, world units.
struct Moments {
    double amount = 0;
    Vec3d middle{0.0};
};

template <class GridType>
Moments momentsOf(const GridType& grid, int c) {
    Moments sum;
    const double volume = std::abs(grid.transform().voxelVolume());  // mirrored ones have a sign
    forEachActive(grid, [&](const auto& value, const openvdb::CoordBBox& box) {
        const double amount = double(channel(value, c)) * volume * double(box.volume());
        sum.amount += amount;
        sum.middle += grid.indexToWorld((box.min().asVec3d() + box.max().asVec3d()) * 0.5) * amount;
    });
    sum.middle /= sum.amount;
    return sum;
}

template <class GridType>
void expectSameMoments(double& amount, double& middle) {
    const typename GridType::Ptr grid = fire<GridType>();
    for (const Transform::Ptr& transform : transforms()) {
        const auto moved = openvdb::gridConstPtrCast<GridType>(depositedOnto(grid, *transform));
        EXPECT_EQ(moved->transform(), *transform);
        for (int c = 0; c < kChannels<typename GridType::ValueType>; ++c) {
            const Moments before = momentsOf(*grid, c), after = momentsOf(*moved, c);
            test::raiseTo(amount, std::abs(after.amount / before.amount - 1));
            test::raiseTo(middle,
                          (after.middle - before.middle).length() / std::cbrt(std::abs(transform->voxelVolume())));
        }
    }
}

}  // namespace

// Found: 3.3e-8, the rounding of a float for each voxel, of which there are many. What lies in a coarse voxel moves to
// its middle, so that the centre of gravity stays to less than half a voxel.
TEST(DepositedOnto, KeepsAmountAndCentreOfGravity) {
    double amount = 0, middle = 0;
    expectSameMoments<FloatGrid>(amount, middle);
    expectSameMoments<Vec3SGrid>(amount, middle);
    std::printf("  amount off by %.2g, centre of gravity by %.2g\n", amount, middle);
    EXPECT_LE(amount, 3.6e-8);
    EXPECT_LE(middle, 0.3);
}

// What is even stays so: exactly where axes are parallel, else to how evenly the pieces of a voxel lie.
TEST(DepositedOnto, KeepsWhatIsEvenEven) {
    const FloatGrid::Ptr grid = test::boxVolume(Index3(24), 2);
    double parallel = 0, turned = 0;
    for (const Transform::Ptr& transform : transforms()) {
        const Vec3d edges[3] = {transform->indexToWorld(Vec3d(1, 0, 0)) - transform->indexToWorld(Vec3d(0.0)),
                                transform->indexToWorld(Vec3d(0, 1, 0)) - transform->indexToWorld(Vec3d(0.0)),
                                transform->indexToWorld(Vec3d(0, 0, 1)) - transform->indexToWorld(Vec3d(0.0))};
        const double longest = std::max({edges[0].length(), edges[1].length(), edges[2].length()});
        bool slanted = false;
        for (int a = 0; a < 3; ++a)
            for (int k = 0; k < 3; ++k) slanted = slanted || (a != k && edges[a][k] != 0);
        const auto moved = openvdb::gridConstPtrCast<FloatGrid>(depositedOnto(grid, *transform));
        for (auto on = moved->cbeginValueOn(); on; ++on) {
            const Vec3d at = transform->indexToWorld(on.getCoord());
            bool within = true;
            for (int k = 0; k < 3; ++k) within = within && std::abs(at[k] - 11.5) < 11 - 2 * longest;
            if (within) test::raiseTo(slanted ? turned : parallel, std::abs(double(*on) / 2 - 1));
        }
    }
    std::printf("  off by %.2g, turned %.2g\n", parallel, turned);
    EXPECT_LE(parallel, 2e-7);  // found: 1.8e-7
    EXPECT_LE(turned, 0.0099);  // found: 0.009
}

TEST(DepositedOnto, LeavesVoxelsThatFitAlone) {
    const FloatGrid::Ptr grid = fire<FloatGrid>();
    EXPECT_EQ(depositedOnto(grid, *grid->transform().copy()), grid);
    // Four for one each way: each gets what is in it, and no sliver goes to a neighbour.
    const FloatGrid::Ptr box = test::boxVolume(Index3(4), 3);
    const auto fine = Transform::createLinearTransform(0.25);
    fine->postTranslate(Vec3d(-0.375));
    const auto moved = openvdb::gridConstPtrCast<FloatGrid>(depositedOnto(box, *fine));
    EXPECT_EQ(moved->activeVoxelCount(), 16u * 16 * 16);
    for (auto on = moved->cbeginValueOn(); on; ++on) ASSERT_FLOAT_EQ(*on, 3);
}

TEST(DepositedOnto, HasTheSameBitsForAnyNumberOfThreads) {
    const FloatGrid::Ptr grid = fire<FloatGrid>();
    const Transform::Ptr transform = transforms()[8];
    const auto all = depositedOnto(grid, *transform);
    const ThreadLimit one(1);
    EXPECT_TRUE(test::sameBits(*depositedOnto(grid, *transform), *all));
}

TEST(DepositedOnto, RefusesWhatHasNoPlace) {
    const FloatGrid::Ptr far = test::boxVolume(Index3(2), 1);
    far->setTransform(Transform::createLinearTransform(1e12));
    test::expectError<InvalidArgument>([&] { depositedOnto(far, *Transform::createLinearTransform(1)); },
                                       "are their transforms in the same units?");
    const FloatGrid::Ptr large = FloatGrid::create();
    large->tree().addTile(2, Coord(0), 1.0f, true);
    EXPECT_THROW(depositedOnto(large, *Transform::createLinearTransform(0.001)), InvalidArgument);  // memory
    const FloatGrid::Ptr frustum = FloatGrid::create();
    frustum->setTransform(Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(8)), 0.5, 1));
    EXPECT_THROW(depositedOnto(frustum, *Transform::createLinearTransform(1)), InvalidArgument);
}
