/// The visual hull of what photographs show: voxels that every picture which sees them has something at.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/projector/composite_volume.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

#include <vector>

namespace raysweep {

/// Voxels that each picture shows with an alpha above `threshold` somewhere in what is seen of the voxel and of the
/// space to its neighbours' centres: linear interpolation carries light that far. A picture that has the object at its
/// border does not know what is outside; of others it is known that nothing is.
std::vector<MaskedBrick> photoHull(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                                   float threshold);

/// `bricks`, and with each of their voxels the 26 around it.
std::vector<MaskedBrick> withNeighbours(const std::vector<MaskedBrick>& bricks, const Index3& dims);

}  // namespace raysweep
