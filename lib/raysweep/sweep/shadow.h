/// Which pixels a box of voxels falls on.
#pragma once

#include "raysweep/sweep/footprint.h"

namespace raysweep {

/// Voxels [low, high).
struct VoxelBox {
    Index3 low, high;
};

/// Pixels [low, high), rows as ViewFootprint counts them.
struct PixelBox {
    int lowColumn, highColumn, lowRow, highRow;
};

struct Shadow {
    PixelBox pixels;  ///< all whose rays give anything to a voxel of the box, and maybe some more
    bool whole;       ///< false if a part of the shadow lies off the detector, or is not known
};

Shadow shadowOf(const VoxelBox& box, const ViewFootprint& footprint);

/// In how many views the volume falls on a pixel. @throw InvalidArgument if in none.
int requireSeen(const ProjectionGeometry& geometry, const ColumnLattice& lattice);

}  // namespace raysweep
