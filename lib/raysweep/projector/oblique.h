/// Rays that follow no columns: tilted detectors, and rays steeper along the columns than across. Each ray is for
/// itself, slices may lie across any axis.
#pragma once

#include "raysweep/projector/backproject.h"
#include "raysweep/projector/project.h"

namespace raysweep {

/// Detector columns [first, last) of a projection.
void projectOblique(const ColumnVolume& volume, int first, int last, ViewRays& rays);

/// Adds the part of one view to the sums of one tile (see backprojectTile).
void backprojectOblique(const ColumnVolume& layout, std::size_t tile, const ViewRays& rays, float* values,
                        float* weights);

}  // namespace raysweep
