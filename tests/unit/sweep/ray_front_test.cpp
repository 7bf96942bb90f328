#include "raysweep/sweep/ray_front.h"

#include <gtest/gtest.h>

#include <set>

#include "raysweep/sweep/directions.h"

using namespace raysweep;

namespace {

BrickLayout boxLayout(const Index3& low, const Index3& high) {
    BrickLayout layout;
    for (int x = low.x; x < high.x; x += 8)
        for (int y = low.y; y < high.y; y += 8)
            for (int z = low.z; z < high.z; z += 8) layout.origins.emplace_back(x, y, z);
    layout.low = low;
    layout.high = high;
    return layout;
}

bool isInside(const RayFront& front, int row, int column, int k) {
    const auto inside = [&](const Lateral& lateral, int ray) {
        const int voxel = ray + lateral.shift(k);
        return lateral.periodic || (voxel >= lateral.low - front.reach && voxel < lateral.high);
    };
    return inside(front.row, row) && inside(front.column, column);
}

/// (row, column) of all rays that are inside in some slice, found by trying.
std::set<std::pair<int, int>> raysByTrying(const RayFront& front) {
    std::set<std::pair<int, int>> rays;
    const RayRange rows = rayExtent(front, front.row), columns = rayExtent(front, front.column);
    for (int r = rows.begin; r < rows.end; ++r)
        for (int c = columns.begin; c < columns.end; ++c)
            for (int k = 0; k < front.slices; ++k)
                if (isInside(front, r, c, k)) rays.insert({r, c});
    return rays;
}

}  // namespace

TEST(RayFront, RaysThatEnterAreThoseFoundByTrying) {
    const BrickLayout layout = boxLayout({-16, 8, 0}, {8, 24, 40});
    std::mt19937_64 random(4);
    DirectionSequence directions({DirectionSet::random, 1, 2});
    for (int trial = 0; trial < 100; ++trial) {
        Vec3 direction = directions.nextGroup(1).front();
        if (trial < 6) direction = Vec3(trial / 2 == 0, trial / 2 == 1, trial / 2 == 2) * (trial % 2 ? 1.0 : -1.0);
        if (trial == 6) direction = Vec3(1, 1, 1);  // slopes of exactly 1
        const Periodic periodic{trial % 5 == 1, trial % 5 == 2, trial % 7 == 3};
        RayFront front = parallelFront(layout, direction, trial % 2, {uniform01(random), uniform01(random)}, periodic);
        front.periodic = false;
        const auto expected = raysByTrying(front);
        std::set<std::pair<int, int>> found;
        const RayRange rows = rayExtent(front, front.row);
        for (int r = rows.begin - 3; r < rows.end + 3; ++r) {
            const RayRange columns = raysThatEnter(front, r);
            if (front.row.periodic && (r < rows.begin || r >= rows.end)) continue;
            for (int c = columns.begin; c < columns.end; ++c) found.insert({r, c});
        }
        EXPECT_TRUE(found == expected) << "trial " << trial;
        EXPECT_EQ(countRaysThatEnter(front), double(expected.size())) << "trial " << trial;
    }
}

TEST(RayFront, CrossSectionAndStepBelongToTheDirection) {
    const BrickLayout layout = boxLayout({0, 0, 0}, {8, 8, 8});
    const Vec3 direction = Vec3(1, 2, -3).normalized();
    const RayFront front = parallelFront(layout, direction, 0, {}, {});
    EXPECT_EQ(front.axis.major, 2);
    EXPECT_FALSE(front.ascending);
    EXPECT_EQ(front.firstSlice, 7);
    EXPECT_LE(std::abs(front.stepLength - 1 / std::abs(direction.z)), 1e-14);
    EXPECT_LE(std::abs(front.crossSection - std::abs(direction.z)), 1e-14);
    // In voxels that are longer along x the same direction is steeper there.
    BrickLayout longer = layout;
    longer.worldFromIndex = Matrix3(0.1, 0, 0, 0, 1, 0, 0, 0, 1);
    longer.voxelVolume = 0.1;
    const RayFront other = parallelFront(longer, direction, 0, {}, {});
    EXPECT_EQ(other.axis.major, 0);
    EXPECT_LE(std::abs(other.stepLength - 0.1 / direction.x), 1e-14);
    EXPECT_LE(std::abs(other.crossSection - direction.x), 1e-14);
}

// In a volume that repeats along the sweep's axis a ray goes on as if there were no border.
TEST(RayFront, RaysGoOnIntoTheNextRepetition) {
    const BrickLayout layout = boxLayout({0, 0, -8}, {8, 16, 24});
    const Vec3 direction = Vec3(3, -0.7, 0.9).normalized();  // major axis x
    const Periodic periodic{true, true, false};
    const RayFront first = parallelFront(layout, direction, 0, {0.3, 0.6}, periodic);
    ASSERT_TRUE(first.periodic);
    RayFront front = first;
    int row = 5, column = -2;
    for (int repetition = 1; repetition < 20; ++repetition) {
        row = rayInNextRepetition(front, front.row, row);
        column = rayInNextRepetition(front, front.column, column);
        front = nextRepetition(front);
        EXPECT_LE(std::abs(front.column.position(0) + column - first.column.position(8 * repetition) - -2), 1e-12);
        const double there = 5 + first.row.position(8 * repetition);
        EXPECT_LE(std::abs(std::remainder(front.row.position(0) + row - there, 16)), 1e-12);
        EXPECT_GE(row, 0);
        EXPECT_LT(row, 16);
    }
}
