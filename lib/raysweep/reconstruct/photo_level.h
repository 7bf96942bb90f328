/// The volume of a fit of photographs at one resolution.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/projector/composite_volume.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/voxel_fit.h"

#include <cstddef>
#include <vector>

namespace raysweep {

/// A volume in the making: bricks with parameters, derivatives and moments, 64 bytes a voxel.
struct PhotoLevel {
    ReconstructionGrid grid;
    CompositeLayout layout;
    std::vector<CompositeVoxel> voxels, gradient;
    std::vector<AdamMoments> moments;
    std::vector<VoxelMask> solid;  ///< voxels that may have extinction; those around them are kept for their colour,
                                   ///< which samples between both take their part of

    bool isSolid(std::size_t voxel) const {
        return isSet(solid[voxel >> 9], int(voxel >> 6 & 7), int(voxel >> 3 & 7), int(voxel & 7));
    }
};

/// The first grid: all of the hull in the same grey haze.
/// @throw InvalidArgument if the hull is empty
PhotoLevel firstLevel(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid, float hullThreshold);

/// The next grid: what the coarse one has there, without what that has emptied.
/// @param prune extinction below which a coarse voxel without others around it is empty
PhotoLevel finerLevel(const PhotoLevel& coarse, const std::vector<Photograph>& photographs,
                      const ReconstructionGrid& grid, float hullThreshold, float prune);

}  // namespace raysweep
