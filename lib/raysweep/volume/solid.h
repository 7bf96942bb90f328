/// Level sets as solids.
#pragma once

#include "raysweep/volume/grids.h"

namespace raysweep {

/// The inside of a level set as density: 1 - but for the voxels that the surface crosses, where it falls to 0 within
/// one voxel's length, 1/2 on the surface. Deep inside there are tiles. The argument is left as it is.
/// @throw InvalidArgument if there is no inside
openvdb::FloatGrid::Ptr levelSetToSolid(const openvdb::FloatGrid& levelSet);

}  // namespace raysweep
