/// The volume of a fit of photographs as grids.
#pragma once

#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/photo_result.h"

#include <vector>

namespace raysweep {

/// Sets density, opacity and colour.
void addGrids(const PhotoLevel& level, PhotoReconstruction& result);

/// Sets the coefficients of colours that depend on the direction. After addGrids.
/// @param constants the part of each voxel's colour that does not
void addDirectional(const PhotoLevel& level, const std::vector<CompositeVoxel>& constants, PhotoReconstruction& result);

}  // namespace raysweep
