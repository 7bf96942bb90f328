#include "raysweep/reconstruct/voxel_update.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "unit/instruction_sets.h"

using namespace raysweep;

// Against the formula, voxel by voxel. A fused multiply-add rounds once where the formula here may round twice:
// found, 2.4e-7.
TEST(VoxelUpdate, IsItsFormulaOnAllInstructionSets) {
    constexpr int kCount = 5 * 16;
    alignas(64) float voxels[kCount];
    float before[kCount], values[kCount], weights[kCount];
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(-2, 2);
    for (int i = 0; i < kCount; ++i) {
        before[i] = uniform(random);
        values[i] = uniform(random);
        weights[i] = std::max(0.0f, uniform(random));  // half of the voxels are met by no ray
    }
    const VoxelUpdate update{0.7f, -1.5f, 1.8f};
    test::forEachInstructionSet([&] {
        std::copy_n(before, kCount, voxels);
        updateVoxels(voxels, values, weights, kCount, update);
        for (int i = 0; i < kCount; ++i) {
            const float followed = before[i] + update.relaxation * values[i] / weights[i];
            const float expected = weights[i] > 0 ? std::clamp(followed, update.lower, update.upper) : before[i];
            EXPECT_NEAR(voxels[i], expected, 2.6e-7f) << i;
        }
    });
}
