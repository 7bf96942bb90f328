/// Line integrals through a volume: what X-rays of a view lose.
#pragma once

#include "raysweep/projector/column_volume.h"
#include "raysweep/projector/fan_image.h"
#include "raysweep/projector/joseph.h"

namespace raysweep {

/// A view's rays through a volume, and two numbers for each. The solvers keep one of these for as long as they work on
/// a view, so that nothing is allocated while they do.
struct ViewRays {
    ViewFootprint footprint;
    FanImage values, weights;  ///< of each pixel
    /// The same brought to the voxels' z, where all rays of a view stay at one (see readyRays).
    FanImage levelValues, levelWeights;
};

/// Rays of that view. `rays` may be those of another one: their memory is used again, and their numbers stay if the
/// sizes are the same; otherwise all are 0.
void aim(ViewRays& rays, const ProjectionGeometry& geometry, int view, const ColumnLattice& lattice);

/// Sets `values` to the line integrals A x, and `weights` to A 1, those of a volume that is 1 wherever voxels are kept
/// (world units).
void projectView(const ColumnVolume& volume, ViewRays& rays);

}  // namespace raysweep
