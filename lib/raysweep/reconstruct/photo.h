/// One call from photographs to a volume with opacity and colour.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/photo_fit.h"
#include "raysweep/reconstruct/photo_light.h"
#include "raysweep/reconstruct/photo_result.h"
#include "raysweep/reconstruct/photo_sart.h"
#include "raysweep/volume/color_volume.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace raysweep {

enum class PhotoMethod {
    fit,         ///< the exact derivative of compositing (photo_fit.h): colours as they are seen, whatever the light
    consistent,  ///< corrections of optical depth (photo_sart.h, eq. 2)
    paper        ///< corrections as the paper makes them (eq. 1)
};

struct PhotoOptions {
    PhotoMethod method = PhotoMethod::fit;
    int iterations = 0;     ///< passes over all photographs, of `fit` in the finest grid, >= 0; 0: as `fit` says, 4 for
                            ///< `consistent`, 12 for `paper`
    double relaxation = 1;  ///< part of a correction that is made, in (0,2]; not of `fit`
    int resolution = 0;     ///< voxels along the longest edge of the box, multiple of 8, 16 to 1024; 0: as `fit` says,
                            ///< 128 for `consistent` and `paper`
    std::optional<Box3> box;                 ///< of the volume, world units; without it what the photographs show
    std::optional<ReconstructionGrid> grid;  ///< instead of `resolution` and `box`
    std::optional<ColorVolume> reference;    ///< of which the history tells the RMS difference (of `fit`, in its last
                                             ///< point); without `grid` its voxels are used: those in `box`, else the
                                             ///< active ones
    std::uint32_t seed = 1;                  ///< of what is random
    int historyEvery = 0;                    ///< updates from one point of the history to the next; 0: a pass; >= 0
    PhotoIllumination light;                 ///< not of `fit`
    bool findLight = false;                  ///< instead of what `light` says; the object must have turned
    PhotoLightOptions lightSearch;
    PhotoFitOptions fit;  ///< all that is not said above; small sets get smaller updates than it says

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// The volume that photographs show. The same bits for any number of threads.
/// @throw InvalidArgument as PhotoOptions::validate, fitPhotographs, findLight and photoSart; for references whose
/// voxels are no cubes along the world's axes
PhotoReconstruction reconstructPhotographs(const std::vector<Photograph>& photographs, const PhotoOptions& options,
                                           const ProgressCallback& progress = {});

}  // namespace raysweep
