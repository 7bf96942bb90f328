/// The last step of SART: voxels follow the mean of their rays' residuals (sart.h, eq. 2).
#pragma once

#include <cstddef>

namespace raysweep {

struct VoxelUpdate {
    float relaxation = 1;  ///< lambda
    float lower, upper;    ///< bounds of the result
};

/// voxel = clamp(voxel + relaxation * value / weight), where there is a weight. Whole vectors of up to 16 voxels, so
/// `count` is a multiple of 16 (as blocks of a ColumnVolume are) and `voxels` lie at a multiple of 64 bytes.
void updateVoxels(float* voxels, const float* values, const float* weights, std::size_t count,
                  const VoxelUpdate& update);

}  // namespace raysweep
