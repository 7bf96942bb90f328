/// Anisotropic scattering as isotropic scattering in a thinner medium, by similarity (Wyman, Patterson and Wilson,
/// Applied Optics 28, 1989).
///
/// Light that is scattered with a mean cosine g goes on, in the part g of the cases, as if nothing had happened. So
/// what is left is an isotropic medium of
///
///     extinction' = extinction (1 - albedo g),    albedo' = albedo (1 - g) / (1 - albedo g):
///
/// the same absorption, and the scattering times (1 - g). Exact for the fluence far from boundaries and sources in a
/// medium that absorbs little; docs/validation.md has the error for others.
#pragma once

#include "raysweep/volume/medium.h"

namespace raysweep {

/// The isotropic medium similar to `medium` with mean cosine `g` of its phase function (for Henyey and Greenstein's,
/// their g). With an albedo grid the extinction becomes a grid of its own, called "extinction", 1/world unit, of scale
/// 1.
/// @param g in (-1,1); 0 returns `medium` as it is
/// @throw InvalidArgument for g out of range; where g is not 0 for a coloured albedo, which would need an extinction
/// for each wavelength, and for voxels that light transport cannot work with.
Medium similarIsotropicMedium(const Medium& medium, double g);

}  // namespace raysweep
