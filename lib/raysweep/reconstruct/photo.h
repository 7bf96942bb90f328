/// One call from photographs freed of their backdrop to a volume, whatever the method.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/photo_fit.h"
#include "raysweep/reconstruct/photo_result.h"
#include "raysweep/reconstruct/photo_sart.h"

#include <optional>
#include <vector>

namespace raysweep {

enum class PhotoMethod {
    fit,         ///< fitPhotographs; colours are those that are seen
    consistent,  ///< photoSart, eq. 2
    paper        ///< photoSart, eq. 1
};

struct PhotoOptions {
    PhotoMethod method = PhotoMethod::fit;
    int resolution = 128;     ///< voxels along the longest edge of the box, in [8,1024]; made a multiple of 8
    std::optional<Box3> box;  ///< of the volume, world units; without it what the photographs show, or the reference's
    PhotoFitOptions fit;    ///< what it says of grid and seed is not looked at; this and the next have the methods' own
                            ///< options
    PhotoSartOptions sart;  ///< `form` and `seed` are not looked at
    bool searchLight = false;  ///< consistent, paper: the light of the photographs is found (photo_light.h), in place
                               ///< of `sart.light`
    std::uint32_t seed = 1;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// @param reference of which the history tells the RMS difference (fit: its last point only), in the volume's grid,
/// which then has the reference's voxels, not `resolution`; may be null
/// @throw InvalidArgument as the options' validate() and the methods; if cameras look at nothing in common and no box
/// is given; for references whose voxels are no cubes along the world's axes
PhotoReconstruction reconstructPhotographs(const std::vector<Photograph>& photographs, const PhotoOptions& options = {},
                                           const ColorVolume* reference = nullptr,
                                           const ProgressCallback& progress = {});

}  // namespace raysweep
