/// Mattes for people to look at.
#pragma once

#include "raysweep/image/image.h"
#include "raysweep/image/matting.h"

namespace raysweep {

/// The matte over a checkerboard, and to the right of it alpha in grey (encoded for display, alpha is the file's value)
/// with inconsistent pixels red. RGB, twice as wide as `matte`.
/// @param matte RGBA @param inconsistent of each pixel; empty: none @throw InvalidArgument if sizes do not match
Image mattePicture(const Image& matte, const std::vector<char>& inconsistent = {});

/// What viewers show of an RGBA picture before a grey of `backdrop`, in display-encoded values: E(L / alpha) alpha +
/// (1 - alpha) backdrop, with E the sRGB curve and its argument clipped to [0,1]. Most programs mix encoded values, and
/// so do those that judge pictures of this kind.
/// @param picture RGBA, linear, premultiplied @param backdrop encoded, in [0,1] @return RGB, encoded
/// @throw InvalidArgument
Image shownBefore(const Image& picture, float backdrop);

/// Means over squares of `factor` x `factor` pixels, in linear light, of all channels (premultiplied colours, so what
/// is not covered has no say). Columns and rows that fill no square are left out, on the right and at the bottom.
/// @throw InvalidArgument if `factor` is not positive or larger than the picture
Image reduced(const Image& picture, int factor);

}  // namespace raysweep
