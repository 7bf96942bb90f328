/// Colours of a fit of photographs that depend on where they are seen from (volume/directional_color.h, eq. 1). A
/// camera's rays see the volume with the colours that it has from there (showVoxels): compositing and its derivative
/// are those of colours alike from all sides, and what the derivative is for the coefficients follows voxel by voxel
/// (chainColors).
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/voxel_fit.h"

#include <vector>

namespace raysweep {

/// Where one looks from, in voxels.
struct ViewPoint {
    bool parallel = false;
    Vec3 place{0};      ///< of the camera; unless parallel
    Vec3 direction{0};  ///< of all rays, length 1; if parallel
};

ViewPoint viewPoint(const PhotoCamera& camera, const ReconstructionGrid& grid);

/// Eq. 1 for all voxels; extinction as it is.
void showVoxels(const PhotoLevel& level, const ViewPoint& from, std::vector<CompositeVoxel>& shown);

/// The derivative with respect to what was shown becomes that with respect to c₀, which is none where eq. 1 cuts off,
/// and what it is for the other coefficients is added to the level's `slopeGradient`.
void chainColors(const ViewPoint& from, const std::vector<CompositeVoxel>& shown, PhotoLevel& level);

/// Added to the loss: `total` times the total variation of u = coefficient / (2 root of c₀), which is a difference of
/// roots, as stepSlopes moves it, and `pull` times that of u and 0.
struct SlopeWeights {
    float total = 0, pull = 0;
};

/// Adds to `slopeGradient` what follows from SlopeWeights; roots are held.
void smoothSlopes(const SlopeWeights& weights, PhotoLevel& level);

/// A step of Adam for the voxels that are kept and have a derivative, which is cleared; as long as one of the root of
/// c₀ would be. @param step its colorRate is that of u
void stepSlopes(const AdamStep& step, PhotoLevel& level);

/// What the photographs see of each voxel: the mean of its colour over all rays, by its part in them (composite.h, eq.
/// 2: ∂C/∂c); where there is none, c₀. Uses the level's `gradient`.
std::vector<CompositeVoxel> meanColors(const std::vector<Photograph>& photographs, PhotoLevel& level);

}  // namespace raysweep
