/// What rays have left for the voxels around their samples.
#pragma once

#include "raysweep/projector/composite.h"

#include <vector>

namespace raysweep {

/// Go through the volume as one piece: their samples stay in the first cache.
constexpr std::size_t kRaysTogether = 16;

/// Adds all shares of a tape to the voxels, by the weights with which samples were interpolated. The same bits for any
/// number of threads. @param rays those of the tape, in pieces of kRaysTogether, those of a major axis together
void spreadShares(const CompositeLayout& layout, const std::vector<CompositeRay>& rays, const CompositeTape& tape,
                  CompositeVoxel* sums);

}  // namespace raysweep
