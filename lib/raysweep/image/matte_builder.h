/// What all methods of matting share. For this module's own sources.
#pragma once

#include "raysweep/image/matting.h"

namespace raysweep {

/// @throw InvalidArgument if `picture` is empty, has other than 1 to 4 channels, or has values that are not finite.
void requirePicture(const Image& picture, const char* what);

/// As requirePicture, and for alpha below 1: what was behind is not known any more.
void requireOpaquePicture(const Image& picture, const char* what);

/// Colour of a pixel of 1 to 4 channels, the last of 2 and 4 being alpha.
inline Color colourOf(const float* pixel, int channels) {
    return channels < 3 ? grey(pixel[0]) : Color(pixel[0], pixel[1], pixel[2]);
}

/// Co of `colour` before `backdrop`, so that it is possible for an object that emits nothing: within [0,alpha].
Color freed(const Color& colour, float alpha, const Color& backdrop);

inline void setPixel(Image& matte, std::size_t pixel, const Color& colour, float alpha) {
    float* const to = matte.pixels.data() + 4 * pixel;
    to[0] = colour.x, to[1] = colour.y, to[2] = colour.z, to[3] = alpha;
}

/// Counts what is covered.
void countCoverage(Matte& matte);

/// Sets alpha to 1 in gaps of at most `largest` pixels: pixels with alpha < 1 that hang together (by their sides) and
/// do not reach the picture's border.
void fillHoles(std::vector<float>& alpha, int width, int height, double largest, MatteReport& report);

/// A shift at which the pair is much more consistent than as it is; nothing if there is none.
std::optional<Misregistration> findMisregistration(const Image& onWhite, const Image& onBlack,
                                                   const MattingOptions& options);

}  // namespace raysweep
