// Bricks in the order of a sweep, and the rays that meet them.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>

#include "raysweep/sweep/directions.h"
#include "raysweep/sweep/sweep.h"
#include "raysweep/sweep/wavefront.h"

using namespace raysweep;

namespace {

/// Bricks scattered at random over a box of 40 x 12 x 40 bricks, wide enough for several strips of the wavefront.
BrickLayout scatteredLayout(double share) {
    std::mt19937_64 random(8);
    BrickLayout layout;
    for (int x = -20; x < 20; ++x)
        for (int y = -6; y < 6; ++y)
            for (int z = -20; z < 20; ++z)
                if (uniform01(random) < share) layout.origins.emplace_back(8 * x, 8 * y, 8 * z);
    layout.low = Index3(-160, -48, -160);
    layout.high = Index3(160, 48, 160);
    return layout;
}

/// How many rays meet each voxel: voxels are nearly transparent, and each ray leaves in each about 1 of the much that
/// it carries.
std::vector<int> raysMet(const SweepVolume& volume, const RayFront& front) {
    constexpr float kThin = 1e-6f;
    const std::size_t bricks = volume.layout.brickCount();
    BrickField tau(bricks), unshot(bricks), deposit(bricks), zero(1);
    for (std::size_t b = 0; b < bricks; ++b) std::fill_n(tau.brick(b), kBrickVoxels, kThin);
    ExchangeFields fields;
    fields.tau = viewOf(tau);
    fields.albedo[0] = fields.source[0] = sharedView(zero);
    fields.unshot[0] = viewOf(unshot);
    fields.deposit[0] = viewOf(deposit);
    Beam beam;
    beam.front = front;
    beam.entering[0] = 1 / kThin;
    sweep(volume, {beam}, Interpolation::nearest, fields, {});
    std::vector<int> met;
    for (std::size_t b = 0; b < bricks; ++b)
        for (int i = 0; i < kBrickVoxels; ++i) met.push_back(int(deposit.brick(b)[i] + 0.5f));
    return met;
}

}  // namespace

TEST(BrickIndex, HasEveryBrickOnceInOrder) {
    const BrickLayout layout = scatteredLayout(0.1);
    for (int major = 0; major < 3; ++major) {
        const SweepAxis axis = sweepAxis(major);
        const BrickIndex index(layout.origins, {}, axis);
        std::vector<std::array<int, 3>> keys;
        for (const BrickIndex::Row& row : index.rows())
            for (std::size_t i = row.first; i < row.end; ++i) {
                const BrickIndex::Entry& entry = index.entries()[i];
                keys.push_back({row.layer, row.row, entry.column});
                const Index3& origin = layout.origins[entry.brick];
                EXPECT_EQ(keys.back(), (std::array<int, 3>{origin[axis.major], origin[axis.row], origin[axis.column]}));
            }
        ASSERT_EQ(keys.size(), layout.brickCount());
        for (std::size_t i = 1; i < keys.size(); ++i) ASSERT_LT(keys[i - 1], keys[i]);
    }
}

TEST(BrickIndex, FindsLayersAndTheirRows) {
    const BrickIndex index({{0, 0, 0}, {0, 16, 0}, {0, 16, 8}, {8, 8, 0}}, {}, sweepAxis(0));
    const auto range = [](int first, int end) { return std::make_pair(std::size_t(first), std::size_t(end)); };
    EXPECT_EQ(index.findLayers(0, 8), range(0, 1));
    EXPECT_EQ(index.findLayers(-8, 16), range(0, 2));
    EXPECT_EQ(index.findLayers(16, 24), range(2, 2));
    EXPECT_EQ(index.findRows(index.layers()[0], 0, 16), range(0, 1));
    EXPECT_EQ(index.findRows(index.layers()[0], 8, 24), range(1, 2));
    EXPECT_EQ(index.findRows(index.layers()[1], 0, 8), range(2, 2));
}

TEST(BrickIndex, MarginsAreTheEmptyBricksJustBelow) {
    BrickLayout layout;
    layout.origins = {{0, 0, 0}, {0, 8, 0}};
    layout.high = Index3(8, 16, 8);
    const std::vector<Index3> margins = marginsBelow(layout, BrickMap(layout), {}, sweepAxis(0));
    const std::vector<Index3> expected = {{0, -8, -8}, {0, -8, 0}, {0, 0, -8}, {0, 8, -8}};
    ASSERT_EQ(margins.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
        for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(margins[i][axis], expected[i][axis]) << i;
}

TEST(FrontRays, EveryVoxelMeetsExactlyOneRay) {
    const SweepVolume volume(scatteredLayout(0.05));
    std::mt19937_64 random(4);
    DirectionSequence directions({DirectionSet::fibonacci, 16, 2});
    for (int trial = 0; trial < 16; ++trial) {
        Vec3 direction = directions.nextGroup(1).front();
        if (trial < 3) direction = Vec3(trial == 0, trial == 1, trial == 2);
        if (trial == 3) direction = Vec3(-1, 1, 1);
        const RayFront front =
            parallelFront(volume.layout, direction, 0, {uniform01(random), uniform01(random)}, volume.periodic);
        const std::vector<int> met = raysMet(volume, front);
        EXPECT_EQ(std::count(met.begin(), met.end(), 1), std::ptrdiff_t(met.size())) << "trial " << trial;
    }
}

TEST(FrontRays, EveryVoxelMeetsOneRayInAPeriodicVolume) {
    for (const int edge : {8, 128, 256}) {  // one brick each way, and an even number of them
        BrickLayout layout;
        for (int x = 0; x < edge; x += 8)
            for (int y = 0; y < edge; y += 8) layout.origins.emplace_back(x, y, 0);
        layout.high = Index3(edge, edge, 8);
        const SweepVolume volume(layout, {true, true, false});
        DirectionSequence directions({DirectionSet::fibonacci, 16, 2});
        for (int trial = 0; trial < 16; ++trial) {
            const Vec3 direction = directions.nextGroup(1).front();
            if (majorAxis(direction) != 2) continue;
            const RayFront front = parallelFront(volume.layout, direction, 0, {0.3, 0.8}, volume.periodic);
            EXPECT_EQ(countRaysThatEnter(front), double(edge) * edge);
            const std::vector<int> met = raysMet(volume, front);
            EXPECT_EQ(std::count(met.begin(), met.end(), 1), std::ptrdiff_t(met.size())) << edge << " trial " << trial;
        }
    }
}

TEST(Wavefront, MeetsEveryBrickOnceAndNoneBeforeOneUpwind) {
    const SweepVolume volume(scatteredLayout(0.3));
    DirectionSequence directions({DirectionSet::fibonacci, 12, 2});
    for (int trial = 0; trial < 12; ++trial) {
        const RayFront front = parallelFront(volume.layout, directions.nextGroup(1).front(), 0, {0.2, 0.7}, {});
        const Wavefront wavefront(volume, front, volume.indexFor(front.axis.major, Interpolation::nearest), false);
        // Cells in an order that a wavefront may take: strip by strip.
        std::vector<int> cellOf(volume.layout.brickCount(), -1), stepOf = cellOf;
        int met = 0;
        for (int strip = 0; strip < wavefront.strips(); ++strip)
            for (int slab = 0; slab < wavefront.slabs(); ++slab)
                for (const BrickVisit& visit : wavefront.visits(slab, strip)) {
                    ASSERT_EQ(cellOf[visit.brick], -1);
                    cellOf[visit.brick] = strip * 1000 + slab;
                    stepOf[visit.brick] = met++;
                }
        ASSERT_EQ(met, int(volume.layout.brickCount()));
        const int way[3] = {front.direction.x < 0 ? -1 : 1, front.direction.y < 0 ? -1 : 1,
                            front.direction.z < 0 ? -1 : 1};
        for (std::size_t b = 0; b < volume.layout.brickCount(); ++b)
            for (int sides = 1; sides < 8; ++sides) {
                const Index3 side((sides & 1) * way[0], (sides >> 1 & 1) * way[1], (sides >> 2) * way[2]);
                const std::uint32_t downwind = volume.map.find(volume.layout.origins[b] + side * kBrickEdge);
                if (downwind == kNoBrick) continue;
                EXPECT_LT(stepOf[b], stepOf[downwind]);
                EXPECT_LE(cellOf[b] / 1000, cellOf[downwind] / 1000);
                EXPECT_LE(cellOf[b] % 1000, cellOf[downwind] % 1000);
            }
    }
}
