/// The volume of a fit of photographs at one resolution.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/projector/composite_volume.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/reconstruct/voxel_fit.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace raysweep {

/// By what a voxel's colour changes along the axes that one looks along (volume/directional_color.h): x, y, z; red,
/// green, blue.
struct ColorSlopes {
    float of[3][3] = {};
};

struct SlopeMoments {
    ColorSlopes first, second;
};

/// A volume in the making: bricks with parameters, derivatives and moments, 64 bytes a voxel; with colours that depend
/// on the direction 208, and 16 for what one view shows.
struct PhotoLevel {
    ReconstructionGrid grid;
    CompositeLayout layout;
    std::vector<CompositeVoxel> voxels, gradient;
    std::vector<AdamMoments> moments;
    std::vector<ColorSlopes> slopes, slopeGradient;  ///< empty: colours are the same from all sides
    std::vector<SlopeMoments> slopeMoments;
    std::vector<VoxelMask> solid;  ///< voxels that may have extinction; those around them are kept for their colour,
                                   ///< which samples between both take their part of

    static std::size_t bytesPerVoxel(bool directional) {
        return 2 * sizeof(CompositeVoxel) + sizeof(AdamMoments) +
               (directional ? 2 * sizeof(ColorSlopes) + sizeof(SlopeMoments) + sizeof(CompositeVoxel) : 0);
    }

    bool isSolid(std::size_t voxel) const {
        return isSet(solid[voxel >> 9], int(voxel >> 6 & 7), int(voxel >> 3 & 7), int(voxel & 7));
    }
};

/// Sets what only updates need to 0: derivatives and moments.
void startSteps(PhotoLevel& level);

/// Frees that.
void forgetSteps(PhotoLevel& level);

/// The first grid: all of the hull in the same grey haze.
/// @param finer levels that are to follow  @param directional whether colours shall depend on the direction
/// @throw InvalidArgument if the hull is empty, or the volume will have no room
PhotoLevel firstLevel(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid, float hullThreshold,
                      int finer, bool directional);

/// The next grid: what the coarse one has there, without what that has emptied.
/// @param prune extinction below which a coarse voxel without others around it is empty
/// @return nothing if it has no room
std::optional<PhotoLevel> finerLevel(const PhotoLevel& coarse, const std::vector<Photograph>& photographs,
                                     const ReconstructionGrid& grid, float hullThreshold, float prune);

}  // namespace raysweep
