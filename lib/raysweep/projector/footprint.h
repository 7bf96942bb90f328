/// Footprints: which pixels a box of voxels falls on.
#pragma once

#include "raysweep/projector/joseph.h"

namespace raysweep {

/// Voxels [low, high).
struct VoxelBox {
    Index3 low, high;
};

/// Pixels [low, high), columns and rows as JosephView counts them.
struct PixelBox {
    int lowColumn, highColumn, lowRow, highRow;
};

/// All pixels whose rays give anything to a voxel of the box, and maybe some more.
PixelBox footprintOf(const VoxelBox& box, const JosephView& view);

/// True if the box, from its voxels' outer faces, has all of its footprint between the outer edges of the detector's
/// pixels. False also if that is not known.
bool isOnDetector(const VoxelBox& box, const JosephView& view);

/// In how many views the volume falls on a pixel. @throw InvalidArgument if in none.
int requireSeen(const ProjectionGeometry& geometry, const ColumnLattice& lattice);

}  // namespace raysweep
