/// Albedo where the density is.
#pragma once

#include "raysweep/volume/medium.h"

namespace raysweep {

/// The albedo grid on the voxels of the density: itself where both have one transform, else for each voxel the mean of
/// the albedo in it, interpolated linearly in world space between those voxel centres that are active. So the albedo of
/// coarse voxels reaches as far as they do, and what is inactive does not darken its surroundings; a voxel with no
/// active one near has albedo 0, as everywhere outside of the grid.
/// @param medium with an albedo grid; all values in [0,1]
/// @throw InvalidArgument for transforms that are not linear, and as checkAlbedo does
openvdb::GridBase::ConstPtr albedoOnDensity(const Medium& medium);

}  // namespace raysweep
