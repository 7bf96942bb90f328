/// Media at a lower resolution, and grids sampled at the voxels of others.
#pragma once

#include "raysweep/volume/medium.h"

namespace raysweep {

/// `medium` on voxels 1/resolution times as long (Dachille, Mueller and Kaufman 2000, section 5.1). Density is averaged
/// over volume, which keeps optical depths; albedo is averaged over extinction, which keeps what is scattered. Emission
/// stays as it is. The paper does not say how it made its coarse volumes.
/// @param resolution in (0,1]; 1 gives the same grids
/// @throw InvalidArgument as `coarsened` and `albedoOnDensity` do, and for voxel values that light transport cannot
///        work with
Medium atResolution(const Medium& medium, double resolution);

/// `grid` at the active voxels (and those of active tiles) of `shape` and at all within `margin` voxels of them:
/// interpolated linearly between voxel centres, in world space. Name and metadata are those of `grid`, the transform is
/// that of `shape`, the background 0.
/// @param grid FloatGrid or Vec3SGrid  @param shape likewise; both with linear transforms
/// @throw InvalidArgument for other types and transforms
openvdb::GridBase::Ptr sampledOnto(const openvdb::GridBase& grid, const openvdb::GridBase& shape, int margin = 0);

}  // namespace raysweep
