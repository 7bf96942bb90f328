// The renderer's steps through a block, on every instruction set that the machine has, against plain double precision.
#include "raysweep/render/block_steps.h"

#include "raysweep/render/cell_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "unit/instruction_sets.h"

using namespace raysweep;

namespace {

/// Trilinear interpolation, written down.
double valueAt(const std::vector<float>& block, int channels, int channel, const double (&p)[3]) {
    int low[3];
    double part[3];
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = int(std::min(std::max(std::floor(p[axis]), 0.0), double(kBlockCells - 1)));
        part[axis] = p[axis] - low[axis];
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int side[3] = {corner >> 2, (corner >> 1) & 1, corner & 1};
        double weight = 1;
        int at = 0;
        for (int axis = 0; axis < 3; ++axis) {
            weight *= side[axis] ? part[axis] : 1 - part[axis];
            at = at * kBlockCorners + low[axis] + side[axis];
        }
        sum += weight * double(block[std::size_t(at * channels + channel)]);
    }
    return sum;
}

template <int kChannels>
void expectSteps(const std::vector<float>& block, const BlockSteps& steps) {
    StepValue<kChannels> values[kMostSteps];
    sampleSteps<kChannels>(block.data(), steps, values);
    for (int i = 0; i < steps.count; ++i) {
        double p[3];
        for (int axis = 0; axis < 3; ++axis) p[axis] = double(steps.first[axis]) + i * double(steps.perStep[axis]);
        // Found: 1.9e-7; three interpolations of floats of order 1.
        for (int c = 0; c < kChannels; ++c)
            EXPECT_LE(std::abs(double(values[i][c]) - valueAt(block, kChannels, c, p)), 2.1e-7) << i << " " << c;
    }
    constexpr float kDepth = 1.3f;
    float opacities[kMostSteps];
    findOpacities<kChannels>(values, steps.count, kDepth, opacities);
    for (int i = 0; i < steps.count; ++i) {
        const double density = std::max(0.0, double(values[i][0]));
        EXPECT_LE(std::abs(double(opacities[i]) + std::expm1(-density * double(kDepth))), 4.8e-8) << i;
    }
}

template <int kChannels>
void expectThinOpacities() {
    for (int count = 1; count <= kMostSteps; ++count) {
        StepValue<kChannels> values[kMostSteps] = {};
        for (int i = 0; i < count; ++i) values[i][0] = std::pow(10.0f, -12 + 0.43f * float(i));
        float opacities[kMostSteps];
        findOpacities<kChannels>(values, count, 0.37f, opacities);
        for (int i = 0; i < count; ++i) {
            const double exact = -std::expm1(-double(values[i][0]) * double(0.37f));
            // Found: 7.8e-8, of the opacity itself; the depth and its exponential are rounded.
            EXPECT_LE(std::abs(double(opacities[i]) / exact - 1), 8.5e-8) << values[i][0];
        }
    }
}

}  // namespace

TEST(BlockSteps, AgreeWithPlainInterpolationOnAllInstructionSets) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> any(-0.2f, 1);
    std::vector<float> block(4u * kBlockCorners * kBlockCorners * kBlockCorners);
    for (float& value : block) value = any(random);
    const float slight = 1e-6f;  // rounding puts steps that far outside
    const std::vector<BlockSteps> ways = {{{0, 0, 0}, {0.24f, 0.2f, 0.25f}, kMostSteps},
                                          {{7.9f, 0.1f, 4}, {-0.5f, 0.3f, 0}, 15},
                                          {{-slight, 8 + slight, 3.5f}, {0.1f, -0.25f, 0.01f}, 31},
                                          {{3, 3, 3}, {0, 0, 0}, 1}};
    test::forEachInstructionSet([&] {
        for (const BlockSteps& steps : ways) {
            expectSteps<1>(block, steps);
            expectSteps<2>(block, steps);
            expectSteps<4>(block, steps);
        }
    });
}

TEST(BlockSteps, ThinOnesLoseNoDigitsOnAnyInstructionSet) {
    test::forEachInstructionSet([] {
        expectThinOpacities<1>();
        expectThinOpacities<2>();
        expectThinOpacities<4>();
    });
}
