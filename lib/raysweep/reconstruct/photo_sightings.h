/// A first guess at the light, place by place: as the object turns, the lamp standing still, a place of a surface is
/// seen in several brightnesses b_k, with weights w_k, in the ratio in which
///
///     f_k = α0 + α1 max(0, -light.n_k) + α2 max(0, light.n_k)                                                (1)
///
/// changes for it; α2 <= α1, because what is thin or rough on the scale of a voxel shows something of its other side.
/// The place's colour is the same in all views, and is solved for in closed form, so that a light leaves of it
///
///     Σ_k w_k b_k² - (Σ_k w_k b_k f_k)² / Σ_k w_k f_k²                                                       (2)
///
/// Eq. 2 is cheap: all directions can be tried. What a place shows is not quite what a picture shows there, for there
/// is more along a ray; so this is a guess.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/reconstruct/photo_surfaces.h"

#include <cstddef>
#include <vector>

namespace raysweep {

/// @param pictures as they were reconstructed from, in ambient light
/// @param places of surfaces that are looked at, those best seen
/// @param directions that are tried
Shading guessLight(const std::vector<Photograph>& pictures, const PhotoSurfaces& surfaces, std::size_t places,
                   int directions);

}  // namespace raysweep
