/// Amounts per volume, moved to other voxels so that none is lost.
#pragma once

#include "raysweep/volume/grids.h"

namespace raysweep {

/// `grid`, an amount per world volume, on the voxels of `transform`: each of its voxels is parted among those that it
/// overlaps (overlap.h), and the sum over all of them is what it was, to the rounding of floats. `grid` itself where it
/// has that transform already. Voxels of 0 are not moved. The same bits for any number of threads.
/// @param grid FloatGrid or Vec3SGrid; what is inactive counts as 0
/// @throw InvalidArgument for other types, what Overlap refuses, and for grids that would take more voxels there than
/// there is memory for
openvdb::GridBase::ConstPtr depositedOnto(const openvdb::GridBase::ConstPtr& grid,
                                          const openvdb::math::Transform& transform);

}  // namespace raysweep
