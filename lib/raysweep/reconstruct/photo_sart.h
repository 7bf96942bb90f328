/// A volume from photographs by corrections, one picture after the other: F. Dachille, K. Mueller and A. Kaufman,
/// "Volumetric Backprojection", VolVis 2000, sections 3 and 5.2. What there is so far is composited along the
/// picture's rays (composite.h); what the picture shows more or less is spread over each ray, and voxels take the mean
/// of the rays that pass.
///
/// The paper's form, with a ray's length l in the volume, opacity a and colour C multiplied by opacity:
///
///     a_j <- clamp(a_j + λ <(a_picture - a_seen) / l>),   (a c)_j <- clamp((a c)_j + λ <(C_picture - C_seen) / l>) (1)
///
/// It spreads opacity over empty space, and over what the ray does not see. The consistent form asks for optical
/// depth, in which opacity is linear, and changes what is there by a share of itself (multiplicatively, as MART does:
/// R. Gordon, R. Bender and G. T. Herman, J. theor. Biol. 29, 1970); colours are changed as far as they are seen, the
/// shortest way to the picture's (Kaczmarz). With depth t = -log(1 - a) and the samples' visibility v (composite.h, eq.
/// 2):
///
///     t_j <- clamp(t_j + λ (a_j + 0.01) <(t_picture - t_seen) / Σ (a_s + 0.01) l_s>)
///     c_j <- clamp(c_j + λ <v (C_picture - C_seen) / Σ v_s²>)                                                    (2)
///
/// A pixel that shows nothing but the object says that depth is large, not how large: it only raises it.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/photo_result.h"
#include "raysweep/reconstruct/reconstruction_grid.h"
#include "raysweep/volume/color_volume.h"

#include <cstdint>

namespace raysweep {

enum class PhotoForm {
    paper,      ///< eq. 1, in all voxels of the grid
    consistent  ///< eq. 2, in those of the visual hull
};

/// The light that photographs were taken in.
struct PhotoIllumination {
    Shading shading;    ///< in world space as it is for the first photograph; what is recovered is the colour
                        ///< without it
    bool turns = true;  ///< it goes along with the camera: the object was turned; else it stays with the object
};

struct PhotoSartOptions {
    PhotoForm form = PhotoForm::consistent;
    int iterations = 4;            ///< passes over all photographs, > 0
    int updates = 0;               ///< ends after so many pictures, even in a pass; 0: does not; >= 0
    double relaxation = 1;         ///< part of the correction that is made, in (0,2] (lambda)
    int samplesPerSlice = 1;       ///< of rays, from slice to slice, in [1,16]
    double saturation = 0.995;     ///< consistent: alpha from which a pixel says no more than "at least", in (0,1)
    double hullThreshold = 0.005;  ///< consistent: alpha above which a pixel shows something, in [0,1)
    PhotoIllumination light;
    int historyEvery = 0;    ///< updates from one point of the history to the next; 0: a pass; >= 0
    std::uint32_t seed = 1;  ///< of the order of pictures: shuffled, anew for each pass

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// What corrections start from and are compared with; both may be null. Their voxels must be where those of the grid
/// are.
struct PhotoVolumes {
    const ColorVolume* initial = nullptr;    ///< starts from nothing without it
    const ColorVolume* reference = nullptr;  ///< of which the history tells the RMS difference
};

/// Memory: 32 bytes for each voxel of a brick that is kept; with diffuse light 56; the paper's form 48 and 56; as much
/// as the volume, 16, for the best so far; and the pictures. The same bits for any number of threads.
/// @throw InvalidArgument for options out of bounds, photographs without alpha, cameras of other sizes than their
/// pictures, photographs that show nothing of the grid, voxels that are no cubes, and volumes on other voxels.
PhotoReconstruction photoSart(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                              const PhotoSartOptions& options, const PhotoVolumes& volumes = {},
                              const ProgressCallback& progress = {});

}  // namespace raysweep
