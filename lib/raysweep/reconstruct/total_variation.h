/// Less noise, and edges that stay: total variation.
#pragma once

#include "raysweep/projector/column_volume.h"

namespace raysweep {

/// Euclidean length of a - b over the voxels that are kept; both must keep the same.
double changeLength(const ColumnVolume& a, const ColumnVolume& b);

/// Lowers the sum over all voxels of |gradient| by steps of steepest descent, each of Euclidean length
/// `change / steps`, and keeps voxels within [lower, upper]. E. Y. Sidky and X. Pan, "Image reconstruction in circular
/// cone-beam computed tomography by constrained, total-variation minimization", Phys. Med. Biol. 53, 2008.
/// @param scratch keeps the same voxels; what it holds is lost
void lowerTotalVariation(ColumnVolume& volume, ColumnVolume& scratch, double change, int steps, float lower,
                         float upper);

}  // namespace raysweep
