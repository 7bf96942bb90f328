/// Volumes that Blender shows in their place.
#pragma once

#include "raysweep/volume/vdb_io.h"

#include <string>
#include <vector>

namespace raysweep {

/// Moves every grid of `file` back by half a voxel of its own, and says so in the file's metadata. Blender's Cycles
/// takes voxel (i,j,k) for the cube from (i,j,k) to (i+1,j+1,k+1), OpenVDB for the one around (i,j,k): half a voxel
/// apart, which is another distance for grids of another resolution. Nothing in Blender can move one grid of an object
/// and not the others.
/// @return names of the grids that were left where they are: points, which Cycles does not show as voxels, and
/// transforms that are not linear
/// @throw InvalidArgument as requireOriginal does
std::vector<std::string> moveForCycles(VdbFile& file);

/// Makes of `grid`, 0 where inactive, one that Cycles shows whole: tiles become voxels, since of tiles alone it shows
/// nothing, and a margin of one voxel of 0 is active around them, since it interpolates a
/// vec3s grid to 0 nowhere else.
/// Grids that are neither FloatGrid nor Vec3SGrid stay as they are.
/// @throw InvalidArgument where there is no memory for its voxels
void extendForCycles(openvdb::GridBase& grid);

/// @throw InvalidArgument if the grids of `file` were moved by moveForCycles, and so are not where they belong.
void requireOriginal(const VdbFile& file);

}  // namespace raysweep
