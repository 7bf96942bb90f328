/// Grids as solids: 1 inside, 0 outside.
#pragma once

#include "raysweep/volume/vdb_io.h"

#include <string>

namespace raysweep {

/// The inside of a level set as density: 1 - but for the voxels that the surface crosses, where it falls to 0 within
/// one voxel's length, 1/2 on the surface. Deep inside there are tiles. The argument is left as it is.
openvdb::FloatGrid::Ptr levelSetToSolid(const openvdb::FloatGrid& levelSet);

/// A float grid of `file`, chosen by name as selectDensity does; a level set becomes a solid.
/// @throw InvalidArgument as selectDensity does, and if a level set has no inside.
openvdb::FloatGrid::Ptr selectSolid(const VdbFile& file, const std::string& name = "");

}  // namespace raysweep
