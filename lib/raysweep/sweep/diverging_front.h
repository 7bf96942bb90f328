/// A front of diverging rays: the light of a point source, taken slice by slice through the bricks.
///
/// Space around the source is cut into six pyramids, one for each direction of each axis, and each pyramid into a
/// lattice of cells that are equal in slope and at most one voxel wide in the last slice. A ray carries the power of
/// its cell's exact solid angle, so that all of them together carry all of it; in a slice it meets the (at most 2x2)
/// voxels that the cell's cross-section overlaps, weighted by the overlap. Cells cover a slice without gap or overlap,
/// so no voxel is missed and none counted twice, however the lattice falls on the voxels.
#pragma once

#include "raysweep/sweep/exchange.h"
#include "raysweep/sweep/sweep_volume.h"

namespace raysweep {

/// A point in a volume.
struct PointSource {
    const SweepVolume& volume;
    Vec3 position;  ///< voxel coordinates
    BrickView<const float> tau;
    double scale = 1;                    ///< extinction, 1/world unit, is `scale` * tau
    const Surfaces* surfaces = nullptr;  ///< null: none
};

/// What light of unit power leaves behind.
struct PointDeposit {
    BrickField power;    ///< that collides in each voxel, part of 1
    BrickField furnace;  ///< local furnace of the surfaces' bricks (exchange.h): what would be there if nothing but its
                         ///< own surface came between a voxel and the light; empty without surfaces
    double escaped = 0;  ///< part that leaves the volume or never meets it; with the sum of `power` it makes 1
};

/// Sends out the light of a point, absorbed on its way.
/// @throw InvalidArgument for a source more than 5e8 voxels away
PointDeposit depositFromPoint(const PointSource& source);

}  // namespace raysweep
