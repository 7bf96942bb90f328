/// Backprojection: the adjoint of the forward projection, Aᵀ y with the same weights (joseph.h, eq. 1).
#pragma once

#include "raysweep/projector/column_volume.h"
#include "raysweep/projector/project.h"

#include <cstddef>
#include <vector>

namespace raysweep {

/// What of backprojection is the same for all voxels: multiplies the numbers of `rays` by their rays' length from slice
/// to slice, and where all rays stay at one z brings them to the voxels' z. To be called once before backprojectBlock;
/// uses the numbers up.
/// @param dimZ length of the volume's columns
void prepareBackprojection(ViewRays& rays, int dimZ);

/// Sums over all rays of `views` that meet a voxel, for the voxels of one block, in the block's order: the ray's weight
/// for the voxel (joseph.h, eq. 1) times the ray's value to `values`, Aᵀ y, and times the ray's own weight to
/// `weights`.
void backprojectBlock(const ColumnVolume& layout, std::size_t block, const std::vector<ViewRays>& views, float* values,
                      float* weights);

/// Aᵀ y as a volume, of the values of `rays`. Uses them up.
void backprojectView(ViewRays& rays, ColumnVolume& to);

}  // namespace raysweep
