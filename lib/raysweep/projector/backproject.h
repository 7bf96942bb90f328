/// What rays give to the voxels they meet: the transpose of projectView.
#pragma once

#include "raysweep/projector/column_volume.h"
#include "raysweep/projector/project.h"

#include <cstddef>
#include <vector>

namespace raysweep {

/// Makes the numbers of `rays` ready to be given to voxels: to be called once before backprojectTile. Uses them up.
/// @param dimZ length of the volume's columns
void readyRays(ViewRays& rays, int dimZ);

/// Sums over all rays of `views` that meet a voxel, for the voxels of one tile, in the tile's order: footprint's weight
/// times the ray's value to `values`, A^T y, and times the ray's weight to `weights`.
void backprojectTile(const ColumnVolume& layout, std::size_t tile, const std::vector<ViewRays>& views, float* values,
                     float* weights);

/// A^T y as a volume, of the values of `rays`. Uses them up.
void backprojectView(ViewRays& rays, ColumnVolume& to);

/// How far a voxel follows the mean of what its rays ask for.
struct VoxelUpdate {
    float relaxation = 1;
    float lower, upper;  ///< bounds of the result
};

/// voxel = clamp(voxel + relaxation * value / weight), where there is a weight.
void updateVoxels(float* voxels, const float* values, const float* weights, std::size_t count,
                  const VoxelUpdate& update);

}  // namespace raysweep
