/// How far a ray is from a pixel, as the eye has it (photo_fit.h, eq. 1).
#pragma once

#include "raysweep/projector/composite.h"

#include <array>

namespace raysweep {

/// A pixel as displays encode it.
struct PixelTarget {
    float alpha = 0;
    float color[3] = {0, 0, 0};  ///< encoded straight colour times alpha
};

/// @param pixel RGBA in linear light, RGB multiplied by alpha
PixelTarget pixelTarget(const float* pixel);

/// Mean and variance of the backdrops.
struct Backdrops {
    float mean = 0.5f, variance = 1.0f / 12;
};

/// The differences whose squares make eq. 1: of red, green and blue, and of alpha.
std::array<float, 4> pixelResidual(const PixelTarget& target, const RayColor& seen, const Backdrops& backdrops);

/// @param derivative of the loss with respect to the ray's colour
/// @return the loss: summed over red, green, blue
float pixelLoss(const PixelTarget& target, const RayColor& seen, const Backdrops& backdrops, RayColor& derivative);

}  // namespace raysweep
