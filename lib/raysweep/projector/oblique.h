/// Both projectors (joseph.h, eq. 1) for rays that follow no columns: tilted detectors, and rays steeper along the
/// columns than across. Each ray is for itself, slices may lie across any axis.
#pragma once

#include "raysweep/projector/project.h"

namespace raysweep {

/// Projects onto some detector columns (see projectView).
void projectOblique(const ColumnVolume& volume, IndexRange columns, ViewRays& rays);

/// Adds the part of one view to the sums of one block (see backprojectBlock).
void backprojectOblique(const ColumnVolume& layout, std::size_t block, const ViewRays& rays, float* values,
                        float* weights);

}  // namespace raysweep
