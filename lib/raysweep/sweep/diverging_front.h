/// A front of diverging rays: the light of a point source, stepped slice by slice through the bricks.
///
/// Space around the source is cut into six pyramids, one for each direction of each axis, and each pyramid into a
/// lattice of cells that are equal in slope and at most one voxel wide in the last slice. A ray carries the power of
/// its cell's exact solid angle, so that all of them together carry all of it; in a slice it meets the (at most 2x2)
/// voxels that the cell's cross-section overlaps, weighted by the overlap. Cells tile a slice without gap or overlap,
/// so no voxel is missed and none counted twice, however the lattice falls on the voxels.
#pragma once

#include "raysweep/sweep/exchange.h"
#include "raysweep/sweep/sweep.h"

namespace raysweep {

/// Light of unit power from `position` (voxel coordinates), absorbed on its way.
/// @param sigma extinction, 1/world unit, as `scale` * `tau`
/// @param deposit receives the power (part of 1) that collides in each voxel
/// @return the part that leaves the volume or never meets it; with the sum of `deposit` it makes 1
/// @throw InvalidArgument for a source more than 5e8 voxels away
double depositFromPoint(const SweepVolume& volume, const Vec3& position, BrickView<const float> tau, double scale,
                        BrickField& deposit);

}  // namespace raysweep
