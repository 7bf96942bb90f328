/// Poses of photographs, put right by the volume that they make: a camera is moved to where the volume looks like its
/// picture, if it does so much better from there. Per view a damped Gauss-Newton method (D. W. Marquardt, J. SIAM
/// 11(2), 1963) for six unknowns, the camera's turn about the middle of the grid and its shift. Residuals are those
/// whose squares the fit lowers (photo_loss.h), their slopes central differences of renders; above 0.1 they count by
/// their size (P. J. Huber, Ann. Math. Stat. 35(1), 1964).
///
/// Volumes of few voxels are blurred, and look a little more like each picture from somewhere else, up to half a voxel
/// away: right poses would drift. They gain about a tenth of the residuals by that, wrong ones much more.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/photo_loss.h"

#include <optional>
#include <vector>

namespace raysweep {

/// The cameras of the photographs, those moved that look at the level's volume from a wrong place. What all have moved
/// in common since they were `given` is taken from them (removeCommonMotion). The same bits for any number of threads.
/// @param perSlice samples of rays from slice to slice, > 0
/// @return nothing if all are where they should be
std::optional<std::vector<PhotoCamera>> refinedPoses(const PhotoLevel& level,
                                                     const std::vector<Photograph>& photographs,
                                                     const std::vector<PhotoCamera>& given, const Backdrops& backdrops,
                                                     int perSlice);

}  // namespace raysweep
