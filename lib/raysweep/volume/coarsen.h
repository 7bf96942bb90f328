/// Coarser grids that hold the same amount.
#pragma once

#include "raysweep/volume/grids.h"

namespace raysweep {

/// The grid on voxels 1/resolution times as long along each axis, box-filtered: a voxel holds the average over its
/// volume, every voxel of `grid` weighted by the exact overlap and what is inactive counting as 0, so the integral over
/// the grid is kept, and that over any box of whole coarse voxels. 1/resolution need not be whole. The coarse voxel 0
/// begins where the fine voxel 0 does, whatever is active, so that the frames of a sequence get the same voxels. Active
/// is what overlaps an active voxel; the background is 0. Time and memory follow the active voxels.
/// @param grid FloatGrid or Vec3SGrid with a linear transform
/// @param resolution in (0,1]
/// @throw InvalidArgument for other types, transforms that are not linear, resolutions out of range, and active tiles
///        that would need more memory than the machine has
openvdb::GridBase::Ptr coarsened(const openvdb::GridBase& grid, double resolution);

}  // namespace raysweep
