/// Where the light comes from that an object was photographed in while it turned. Mattes say where it is, whatever the
/// light; so a coarse volume gives surfaces and their normals. As the object turns, the lamp standing still, a place on
/// a surface is seen in several brightnesses, in the ratio in which
///
///     ambient + diffuse max(0, -light.n)                                                                     (1)
///
/// changes for it. Its colour, the same in all views, is solved for in closed form, so that a light leaves of a place's
/// brightnesses b_k, seen with weights w_k, and its own f_k by eq. 1
///
///     Σ_k w_k b_k² - (Σ_k w_k b_k f_k)² / Σ_k w_k f_k²                                                       (2)
///
/// and all directions and shares of ambient light can be tried.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/photo_result.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

namespace raysweep {

struct PhotoLightOptions {
    int resolution = 32;   ///< voxels along the longest edge, in [8,256]
    int views = 48;        ///< photographs that are looked at, at most, > 1
    int passes = 4;        ///< over these, for the coarse volume, > 0
    int places = 6000;     ///< of surfaces, those best seen, > 0
    int directions = 400;  ///< that are tried first, > 1

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// The light that leaves least. Without diffuse light there is nothing to find: then ambient is 1 or the confidence
/// low.
/// @throw InvalidArgument for options out of bounds, and photographs as for photoSart
PhotoLight findLight(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid,
                     const PhotoLightOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace raysweep
