/// Steps of a ray through blocks of cells, many at once.
#pragma once

namespace raysweep {

constexpr int kMostSteps = 32;  ///< that are taken at once

/// Steps in one block.
struct BlockSteps {
    float first[3],
        perStep[3];  ///< where the first is, relative to the block's low corner, and how far the next; voxels
    int count;       ///< at most kMostSteps
};

/// The values at one step; where opacities are found the first is density.
template <int kChannels>
using StepValue = float[kChannels];

/// Interpolates the values of a block linearly at each step.
/// @param block values at corners, as in CellBlocks
template <int kChannels>
void sampleSteps(const float* block, const BlockSteps& steps, StepValue<kChannels>* values);

/// 1 - exp(-density times `depth`) of `count` steps; 0 where density is not above 0.
template <int kChannels>
void findOpacities(const StepValue<kChannels>* values, int count, float depth, float (&opacities)[kMostSteps]);

}  // namespace raysweep
