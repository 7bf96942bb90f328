/// Rays of a detector whose columns lean against the volume's, because it is rolled or tilted (every calibrated C-arm's
/// is). The rays of a detector column lie in one plane, so in each slice across their major axis (joseph.h) they meet
/// one straight line, at
///
///     z(v) = (a + b v) / (c + d v)   for row v,   lateral = offset + lean z
///
/// and a few columns of voxels are beside it instead of two. Projector and backprojector take both numbers from the
/// same expressions, so that they are each other's adjoints, in whole vectors of rows or of voxels.
#pragma once

#include "raysweep/projector/column_volume.h"
#include "raysweep/projector/project.h"

#include <vector>

namespace raysweep {

/// Sets the numbers of `rays` in the given detector columns, all 0, to those of projectView.
void projectRolled(const ColumnVolume& volume, IndexRange columns, ViewRays& rays);

/// backprojectBlock for one view whose numbers are multiplied by lengths; adds to `values` and `weights`.
void backprojectRolled(const ColumnVolume& layout, std::size_t block, const ViewRays& rays, float* values,
                       float* weights);

}  // namespace raysweep
