/// Steps of a ray through a block of cells, all at once.
#pragma once

namespace raysweep {

constexpr int kMostSteps = 32;  ///< that are taken at once

struct BlockSteps {
    float first[3],
        perStep[3];  ///< where the first is, relative to the block's low corner, and how far the next; voxels
    int count;       ///< at most kMostSteps
    float depth;     ///< optical depth of a step through density 1
};

/// What is found at each step.
template <int kChannels>
struct StepValues {
    float opacity[kMostSteps];           ///< 1 - exp(-optical depth); 0 where density is not above 0
    float value[kMostSteps][kChannels];  ///< the block's values, interpolated linearly; the first is density
};

/// @param block values at corners, as in CellBlocks
template <int kChannels>
void sampleSteps(const float* block, const BlockSteps& steps, StepValues<kChannels>& values);

}  // namespace raysweep
