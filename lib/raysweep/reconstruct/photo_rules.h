/// What the samples of a ray are given when its pixel shows more or less than the volume: the rules of photo_sart.h.
#pragma once

#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/photo_views.h"

#include <array>
#include <cstddef>

namespace raysweep {

/// Added to opacity: what is empty can fill, and what is nearly clear is not stuck (photo_sart.h, eq. 2).
constexpr float kLeastOpacity = 0.01f;

/// What a pixel shows more than the volume: red, green, blue, multiplied by opacity.
std::array<float, 3> missing(const std::array<float, 4>& pixel, const RayColor& seen);

/// Eq. 1 of photo_sart.h for ray `r`. @return what the shares are of: what the pixel shows more
std::array<float, 3> paperRule(const PhotoRays& rays, std::size_t r, const RaySamples& samples, SampleShare* shares);

/// Eq. 2 of photo_sart.h for ray `r`. @param mostDepth from which pixels say "at least"
/// @return what the shares are of: what the pixel shows more
std::array<float, 3> consistentRule(const PhotoRays& rays, std::size_t r, float mostDepth, const RaySamples& samples,
                                    SampleShare* shares);

}  // namespace raysweep
