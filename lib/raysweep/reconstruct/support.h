/// The support: where there can be anything at all.
#pragma once

#include "raysweep/camera/projections.h"
#include "raysweep/projector/joseph.h"

#include <vector>

namespace raysweep {

/// The blocks and chunks of columns (8x8x16 voxels) that remain when all are taken away that some view looks through
/// and sees nothing: the visual hull. A pixel sees nothing if its value is at most `threshold`; pixels that were not
/// measured, and what lies off the detector, may hide anything.
/// @param threshold line integral
std::vector<ColumnRange> visualHull(const Projections& projections, const ProjectionGeometry& geometry,
                                    const ColumnLattice& lattice, float threshold);

}  // namespace raysweep
