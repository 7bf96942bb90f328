/// Forward projection: line integrals through a volume, p = A x with Joseph's weights (joseph.h, eq. 1).
#pragma once

#include "raysweep/projector/column_volume.h"
#include "raysweep/projector/joseph.h"
#include "raysweep/projector/ray_image.h"

namespace raysweep {

/// A view's rays through a volume, and two numbers for each. The solvers keep one of these for as long as they work on
/// a view, so that its memory is used again.
struct ViewRays {
    JosephView view;
    /// Of each pixel: A x and A 1 after projectView; the solvers put in what is to be spread back, residuals over
    /// lengths, and as weight 1 for a ray that counts and 0 for one that does not.
    RayImage values, weights;
    /// The same brought to the voxels' z, where all rays of a view stay at one (see prepareBackprojection).
    RayImage levelValues, levelWeights;
};

/// Makes `rays` those of view `number`. They may be those of another one: their memory is used again, and their numbers
/// stay if the sizes are the same; otherwise all are 0.
void setView(ViewRays& rays, const ProjectionGeometry& geometry, int number, const ColumnLattice& lattice);

/// Sets `values` to the line integrals A x, and `weights` to A 1, those of a volume that is 1 wherever voxels are kept
/// (world units).
void projectView(const ColumnVolume& volume, ViewRays& rays);

}  // namespace raysweep
