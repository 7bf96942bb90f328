// Passes of the emulator against sweeps of the library, which shares no code with it but vectors; and what it counts.
#include <gtest/gtest.h>

#include <cmath>

#include "cube4/arithmetic.h"
#include "hardware/random_box.h"
#include "raysweep/core/error.h"
#include "support/worst.h"

using namespace raysweep;
using test::RandomBox;

namespace {

/// Along axis `major`, with slopes along the others that make no ray meet the edge of a voxel.
Vec3 oblique(int major, double way) {
    Vec3 direction;
    direction[major] = way;
    direction[(major + 1) % 3] = 0.3721;
    direction[(major + 2) % 3] = -0.8137;
    return direction;
}

constexpr int kLatency = 11;  ///< cycles from a beam's issue to its rays' return, less the one in which it is issued

}  // namespace

// Each value goes through some ten operations on floats in a sweep. Asked: 1e-6. Found after ten sweeps: U 2.6e-7 and D
// 2.5e-7 of the largest, rays 7e-9.
TEST(Cube4, MovesThePowerThatASweepMoves) {
    for (const int pad : {0, 1})
        for (int axis = 0; axis < 3; ++axis)
            for (const int way : {-1, 1})
                for (const int pipelines : {1, 4, 7}) {
                    SCOPED_TRACE(testing::Message()
                                 << "pad " << pad << " axis " << axis << " way " << way << " p " << pipelines);
                    RandomBox box({2, 3, 2}, pipelines, pad);
                    for (int n = 0; n < 10; ++n) {
                        // Ten sweeps in a row, one straight along the axis; the others as oblique as can be.
                        Vec3 direction(0);
                        direction[axis] = way;
                        if (n > 0) direction = oblique((axis + n) % 3, n % 2 ? way : -way);
                        const LatticeOffset offset{0.31 + 0.05 * n, 0.77 - 0.06 * n};
                        const RaySums sums = box.sweep(direction, offset, 0.3f);
                        const auto result = box.pass(direction, offset, 0.3f);
                        double escaped = 0;
                        for (const auto& ray : result.leaving.rays) escaped += double(ray.value);
                        EXPECT_LE(std::abs(escaped / sums.escaped[0] - 1), 1e-6);
                        EXPECT_LE(std::abs(double(result.raysEntered) * double(test::kEntering) / sums.entered[0] - 1),
                                  1e-12);
                    }
                    EXPECT_LE(box.worstUnshot(), 2.9e-7);
                    EXPECT_LE(box.worstDeposit(), 2.7e-7);
                }
}

TEST(Cube4, ReadsAndWritesAVoxelInTwoCycles) {
    for (int axis = 0; axis < 3; ++axis)
        for (const int pipelines : {1, 2, 4, 8, 16}) {
            RandomBox box({2, 2, 2}, pipelines, 0);
            const auto result = box.pass(oblique(axis, 1), {0.5, 0.5}, 0.3f);
            const std::uint64_t voxels = 16 * 16 * 16, beams = voxels / std::uint64_t(pipelines);
            // From the issue of one beam to that of the next, from the last one to its end, and what was waited for.
            EXPECT_EQ(result.counters.cycles, 2 * beams + kLatency + result.counters.stalls);
            EXPECT_EQ(result.counters.beams, beams);
            EXPECT_EQ(result.counters.voxelReads, voxels);
            EXPECT_EQ(result.counters.voxelWrites, voxels);
            EXPECT_EQ(result.counters.conflicts, 0u);
        }
}

TEST(Cube4, WithoutOverlapTakesTwiceAsLong) {
    RandomBox box({2, 2, 2}, 4, 0), serial({2, 2, 2}, 4, 0);
    cube4::PassOptions options;
    options.overlap = false;
    const auto overlapped = box.pass(oblique(0, 1), {0.5, 0.5}, 0.3f);
    const auto one = serial.pass(oblique(0, 1), {0.5, 0.5}, 0.3f, options);
    EXPECT_EQ(overlapped.counters.cycles, 2u * 1024 + kLatency);
    EXPECT_EQ(one.counters.cycles, 4u * 1024 + kLatency - 2);
    for (std::size_t i = 0; i < overlapped.leaving.rays.size(); ++i)
        ASSERT_EQ(overlapped.leaving.rays[i].value, one.leaving.rays[i].value);
}

// Beams that end with a part of p voxels cost as much as whole ones.
TEST(Cube4, PartialBeamsCostWholeOnes) {
    RandomBox box({2, 2, 2}, 5, 0);
    EXPECT_EQ(box.pass(oblique(1, -1), {0.2, 0.4}, 0.3f).counters.beams, 16u * 16 * 4);
    RandomBox wide({2, 2, 2}, 24, 0);
    EXPECT_EQ(wide.pass(oblique(1, -1), {0.2, 0.4}, 0.3f).counters.beams, 16u * 16);
}

TEST(Cube4, OnePipelineHasNoNeighbour) {
    RandomBox one({1, 1, 1}, 1, 0), two({1, 1, 1}, 2, 0);
    EXPECT_EQ(one.pass(oblique(2, 1), {0.5, 0.5}, 0.3f).counters.wordsOn, 0u);
    EXPECT_GT(two.pass(oblique(2, 1), {0.5, 0.5}, 0.3f).counters.wordsOn, 0u);
}

// 8x8x8 voxels lie on 22 diagonals of up to 48, one module each where there are more modules than that.
TEST(Cube4, ModulesAreAsLargeAsTheFullest) {
    EXPECT_EQ(cube4::VoxelMemory<float>(Index3(8), 4).voxelsPerModule(), 128u);
    EXPECT_EQ(cube4::VoxelMemory<float>(Index3(8), 40).voxelsPerModule(), 48u);
}

TEST(Cube4, MemoryWithoutSkewHasConflicts) {
    for (int axis = 0; axis < 3; ++axis) {
        RandomBox box({1, 1, 1}, 4, 0, cube4::Skew::none);
        EXPECT_THROW(box.pass(oblique(axis, 1), {0.5, 0.5}, 0.3f), Error);
    }
}

TEST(Cube4, TraceTellsWhereEachBeamIs) {
    RandomBox box({1, 1, 1}, 4, 0);
    cube4::Trace trace;
    trace.most = 20;
    cube4::PassOptions options;
    options.trace = &trace;
    box.pass(oblique(2, 1), {0.5, 0.5}, 0.3f, options);
    ASSERT_EQ(trace.cycles.size(), 20u);
    // A beam moves on by a stage in each cycle; the router is three.
    for (std::size_t stage = 0; stage + 1 < trace.stages.size(); ++stage)
        for (std::size_t cycle = stage; cycle + 1 < trace.cycles.size(); ++cycle) {
            if (stage + 2 == trace.stages.size()) continue;
            EXPECT_EQ(trace.cycles[cycle][stage].part, trace.cycles[cycle + 1][stage + 1].part);
            EXPECT_EQ(trace.cycles[cycle][stage].slice, trace.cycles[cycle + 1][stage + 1].slice);
        }
    EXPECT_EQ(trace.cycles[0][0].slice, 0);
    EXPECT_EQ(trace.cycles[1][0].slice, -1);  // every other cycle belongs to voxels that are written
    EXPECT_EQ(trace.cycles[2][0].part, 1);
}

// Slices that are done before the rays of the last one are back: the sequencer waits, and what is found does not
// change.
TEST(Cube4, WaitsForRaysThatAreUnderWay) {
    using namespace cube4;
    const Index3 size(5, 4, 7);  // with a layer of empty voxels
    const FloatArithmetic arithmetic;
    const auto project = [&](int pipelines) {
        VoxelMemory<float> memory(size, pipelines);
        for (int i = 0; i < 30; ++i) {
            Voxel<float>& voxel = memory.at(Index3(1 + i % 3, 1 + i / 3 % 2, 1 + i / 6));
            voxel.scalar = 1 + 0.1f * float(i);
            voxel.gain = 1;
        }
        const Traversal traversal =
            traverse(size, {Index3(1), size - Index3(1)}, {Vec3(0.4, -0.3, 1), 0.3, 0.8}, Resampling::linear);
        const auto slices = slicesOf(traversal, arithmetic);
        ExchangeSetup<float> setup;
        setup.pass = Pass::project;
        return runPass(arithmetic, memory, {traversal, slices, setup, RayPlane<float>(traversal, slices)}, pipelines);
    };
    const auto alone = project(1);
    std::uint64_t stalls = 0;
    for (const int pipelines : {2, 8, 40}) {
        const auto result = project(pipelines);
        stalls += result.counters.stalls;
        EXPECT_EQ(result.counters.hazards, 0u);
        for (std::size_t i = 0; i < alone.leaving.rays.size(); ++i)
            ASSERT_EQ(result.leaving.rays[i].value, alone.leaving.rays[i].value) << pipelines;
    }
    EXPECT_GT(stalls, 0u);
}
