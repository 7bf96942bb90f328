/// The visual hull of what photographs show: voxels that every picture which sees them has something at.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/projector/composite_volume.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

#include <vector>

namespace raysweep {

/// Voxels that each picture either has in no part of its frame, or shows with an alpha above `threshold` somewhere in
/// what is seen of the voxel and of the space to its neighbours' centres: linear interpolation carries light that far.
std::vector<MaskedBrick> photoHull(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                                   float threshold);

/// A box around all that the photographs show: from where the cameras look, and then from the visual hull.
/// @throw InvalidArgument if the cameras look at nothing in common, or their pictures show nothing.
Box3 photographedBox(const std::vector<Photograph>& photographs, float threshold);

}  // namespace raysweep
