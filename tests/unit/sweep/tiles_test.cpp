// Bricks in the order of a sweep, and a ray front cut into tiles.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "raysweep/sweep/directions.h"
#include "raysweep/sweep/ray_tiles.h"
#include "raysweep/sweep/sweep.h"

using namespace raysweep;

namespace {

/// Bricks scattered at random over a box of 40 x 12 x 40 bricks, wide enough for several tiles of rays.
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

/// Sweeps walls of optical depth 1e6 with albedo 0 in voxels' stead: each ray ends in the first voxel it meets, so to
/// see all of them voxels are nearly transparent instead, and what is deposited counts the rays.
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
    ExchangeStep step;
    step.entering[0] = 1 / kThin;
    sweep(volume, front, Interpolation::nearest, fields, step);
    std::vector<int> met;
    for (std::size_t b = 0; b < bricks; ++b)
        for (int i = 0; i < kBrickVoxels; ++i) met.push_back(int(deposit.brick(b)[i] + 0.5f));
    return met;
}

}  // namespace

TEST(TileIndex, VisitsEveryBrickOnceInOrder) {
    const BrickLayout layout = scatteredLayout(0.1);
    for (int major = 0; major < 3; ++major) {
        const SweepAxis axis = sweepAxis(major);
        const TileIndex index(layout, axis);
        for (int signs = 0; signs < 8; ++signs) {
            const bool up[3] = {(signs & 1) != 0, (signs & 2) != 0, (signs & 4) != 0};
            std::vector<std::uint32_t> seen;
            index.forEach(up[0], up[1], up[2], [&](std::uint32_t b) { seen.push_back(b); });
            EXPECT_EQ(std::set<std::uint32_t>(seen.begin(), seen.end()).size(), layout.brickCount());
            ASSERT_EQ(seen.size(), layout.brickCount());
            const auto key = [&](std::uint32_t b) {
                const Index3& o = layout.origins[b];
                return std::array<int, 3>{up[0] ? o[axis.major] : -o[axis.major], up[1] ? o[axis.row] : -o[axis.row],
                                          up[2] ? o[axis.column] : -o[axis.column]};
            };
            for (std::size_t i = 1; i < seen.size(); ++i) ASSERT_LT(key(seen[i - 1]), key(seen[i]));
        }
    }
}

TEST(RayTiles, EveryVoxelMeetsExactlyOneRay) {
    const SweepVolume volume(scatteredLayout(0.05));
    std::mt19937_64 random(4);
    DirectionSequence directions(DirectionSet::fibonacci, 16, 2);
    for (int trial = 0; trial < 16; ++trial) {
        Vec3 direction = directions.next();
        if (trial < 3) direction = Vec3(trial == 0, trial == 1, trial == 2);
        if (trial == 3) direction = Vec3(-1, 1, 1);
        const RayFront front =
            parallelFront(volume.layout, direction, 0, uniform01(random), uniform01(random), volume.periodic);
        const std::vector<int> met = raysMet(volume, front);
        EXPECT_EQ(std::count(met.begin(), met.end(), 1), std::ptrdiff_t(met.size())) << "trial " << trial;
    }
}

TEST(RayTiles, EveryVoxelMeetsOneRayInAPeriodicVolume) {
    for (const int edge : {8, 128, 256}) {  // one tile, and an even number of them
        BrickLayout layout;
        for (int x = 0; x < edge; x += 8)
            for (int y = 0; y < edge; y += 8) layout.origins.emplace_back(x, y, 0);
        layout.high = Index3(edge, edge, 8);
        SweepVolume volume(layout);
        volume.periodic = {true, true, false};
        DirectionSequence directions(DirectionSet::fibonacci, 16, 2);
        for (int trial = 0; trial < 16; ++trial) {
            const Vec3 direction = directions.next();
            if (majorAxis(direction) != 2) continue;
            const RayFront front = parallelFront(volume.layout, direction, 0, 0.3, 0.8, volume.periodic);
            EXPECT_EQ(countRaysThatEnter(front), double(edge) * edge);
            const std::vector<int> met = raysMet(volume, front);
            EXPECT_EQ(std::count(met.begin(), met.end(), 1), std::ptrdiff_t(met.size())) << edge << " trial " << trial;
        }
    }
}

TEST(RayTiles, OfOneColourShareNoBrick) {
    const BrickLayout layout = scatteredLayout(0.3);
    DirectionSequence directions(DirectionSet::fibonacci, 12, 2);
    for (int trial = 0; trial < 12; ++trial)
        for (const int reach : {0, 1}) {
            const RayFront front = parallelFront(layout, directions.next(), reach, 0.2, 0.7, {});
            const TileIndex index(layout, front.axis);
            const RayTiles cut = cutIntoTiles(front, layout, index);
            for (std::size_t colour = 0; colour + 1 < cut.colours.size(); ++colour) {
                std::map<std::uint32_t, std::size_t> owner;
                for (std::size_t t = cut.colours[colour]; t < cut.colours[colour + 1]; ++t)
                    for (const BrickVisit* visit = cut.tiles[t].begin; visit != cut.tiles[t].end; ++visit)
                        ASSERT_EQ(owner.try_emplace(visit->brick, t).first->second, t) << "trial " << trial;
            }
        }
}
