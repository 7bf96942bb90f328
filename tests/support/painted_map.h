/// Lat-long pictures for tests, and their geometry by formulas of their own. Up is z, the middle looks along x.
#pragma once

#include <cmath>
#include <cstddef>

#include "raysweep/core/types.h"
#include "raysweep/image/image.h"

namespace raysweep::test {

/// Unit vector towards the point of the sphere at part `u` of the width and `v` of the height.
inline Vec3 towardsPixel(double u, double v) {
    const double azimuth = kPi - 2 * kPi * u, polar = kPi * v;
    return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
}

/// Solid angle of a pixel of row `y`.
inline double pixelSolidAngle(const Image& map, int y) {
    return 2 * kPi / map.width * (std::cos(kPi * y / map.height) - std::cos(kPi * (y + 1) / map.height));
}

/// A map of three channels; `radiance(direction)` gives the colour of the pixel towards `direction`.
template <class Radiance>
Image paintedMap(int width, int height, const Radiance& radiance) {
    Image map(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Color color = radiance(towardsPixel((x + 0.5) / width, (y + 0.5) / height));
            for (int c = 0; c < 3; ++c) map.at(x, y)[c] = color[c];
        }
    return map;
}

/// 1 within `radius` radians of `centre` (unit vector).
inline bool inDisc(const Vec3& direction, const Vec3& centre, double radius) {
    return direction.dot(centre) >= std::cos(radius);
}

/// Integral of the map's radiance over the sphere.
inline Vec3 integralOf(const Image& map) {
    Vec3 sum(0);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            for (int c = 0; c < 3; ++c) sum[c] += double(map.at(x, y)[c]) * pixelSolidAngle(map, y);
    return sum;
}

}  // namespace raysweep::test
