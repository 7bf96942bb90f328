/// Sky maps: a lat-long picture of the light from all around.
///
/// The picture is twice as wide as it is high, the direction up in its top row. With z up its middle looks along +x,
/// a quarter of the width to the left of it is +y, so the picture is as seen from inside: column (0.5 - azimuth /
/// 2 pi) * width, row polar angle / pi * height. That is how Blender's Environment Texture maps it (checked against
/// 3.4). With another axis up the axes follow each other the same way: y up has +z in the middle and +x to the left of
/// it (as OpenEXR's lat-long maps), x up +y and +z.
#pragma once

#include "raysweep/image/image.h"
#include "raysweep/scene/light.h"

#include <vector>

namespace raysweep {

struct SkyMapOptions {
    int up = 2;         ///< axis of world space that is up in the picture: 0 x, 1 y, 2 z
    double rotate = 0;  ///< turns the sky about that axis, counter-clockwise seen from above, degrees
    double scale = 1;   ///< radiance, W m^-2 sr^-1, of a pixel of 1; not negative
    int suns = 16;      ///< most suns that stand for small bright parts; 0: none, in [0, kMostSkySuns]

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

constexpr int kMostSkySuns = 1024;

/// A sky map as the solver takes it.
struct SkyMapLight {
    std::vector<Sun> suns;  ///< small bright parts, which sweeps would find by chance only; each in the power-weighted
                            ///< mean direction of its pixels, with their integral of radiance over solid angle
    Sky sky;                ///< the rest, averaged over cells of 1/64 of a turn in longitude and latitude
    double sunShare = 0;    ///< part of all power (mean of the wavelengths) that the suns carry
};

/// Divides a lat-long map into suns and a sky. The integral of radiance over the sphere is that of the map, each pixel
/// weighted with its exact solid angle.
/// @param map one channel (grey; with a second, which is alpha and ignored) or three (with any more, ignored), linear
/// @throw InvalidArgument for a picture that is not twice as wide as high, smaller than 4 x 2, or with pixels that are
/// negative or not finite, with the first of them; and what `options.validate()` throws
SkyMapLight lightFromSkyMap(const Image& map, const SkyMapOptions& options = {});

}  // namespace raysweep
