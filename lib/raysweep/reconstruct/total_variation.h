/// Total variation, for less noise and edges that stay: E. Y. Sidky and X. Pan, "Image reconstruction in circular
/// cone-beam computed tomography by constrained, total-variation minimization", Phys. Med. Biol. 53, 2008. With
/// differences to the voxel before along each axis (docs/ct.md, eq. 6),
///
///     TV(x) = Σ_s,t,u √((x[s,t,u] - x[s-1,t,u])² + (x[s,t,u] - x[s,t-1,u])² + (x[s,t,u] - x[s,t,u-1])²)       (6)
///
/// where voxels are no cubes, each difference over the voxel's edge along its axis.
#pragma once

#include "raysweep/projector/column_volume.h"

namespace raysweep {

/// Euclidean length of a - b over the voxels that are kept; both must keep the same.
double changeLength(const ColumnVolume& a, const ColumnVolume& b);

struct VariationSteps {
    double change;  ///< Euclidean length of all steps together
    int steps;
    float lower, upper;  ///< bounds of voxels
};

/// Lowers TV by steepest descent, x <- clamp(x - (change / steps) ∇TV / |∇TV|).
/// @param scratch keeps the same voxels; what it holds is lost
void lowerTotalVariation(ColumnVolume& volume, ColumnVolume& scratch, const VariationSteps& how);

}  // namespace raysweep
