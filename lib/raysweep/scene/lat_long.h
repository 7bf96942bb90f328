/// The geometry of lat-long pictures; sky_map.h says how they lie in space.
#pragma once

#include "raysweep/core/types.h"

#include <algorithm>
#include <cmath>

namespace raysweep {

/// A sphere divided into `width` x `height` cells by longitude and latitude, first row up, azimuth falling with the
/// column.
struct LatLong {
    int width = 0, height = 0;

    /// z of the edge above row `y`, exact at both poles.
    double edge(int y) const { return y == 0 ? 1 : y == height ? -1 : std::cos(kPi * y / height); }
    /// Solid angle of a cell of row `y`, sr; those of all cells sum to 4 pi.
    double solidAngle(int y) const { return 2 * kPi / width * (edge(y) - edge(y + 1)); }
    /// Unit vector towards the middle (of the solid angle) of a cell.
    Vec3 direction(int x, int y) const {
        const double azimuth = 2 * kPi * (0.5 - (x + 0.5) / width), z = 0.5 * (edge(y) + edge(y + 1));
        const double r = std::sqrt(1 - z * z);
        return {r * std::cos(azimuth), r * std::sin(azimuth), z};
    }
    int column(const Vec3& towards) const {
        const double u = 0.5 - std::atan2(towards.y, towards.x) / (2 * kPi);
        return std::min(width - 1, std::max(0, int(u * width)));
    }
    int row(const Vec3& towards) const {
        const double polar = std::acos(std::min(1.0, std::max(-1.0, towards.z)));
        return std::min(height - 1, int(polar / kPi * height));
    }
};

/// How a map lies in world space: the axis that is up and a turn about it.
struct MapFrame {
    int up = 2;
    double cosine = 1, sine = 0;  ///< of the turn, counter-clockwise seen from above

    Vec3 toWorld(const Vec3& v) const {
        const Vec3 turned(v.x * cosine - v.y * sine, v.x * sine + v.y * cosine, v.z);
        Vec3 world;
        for (int i = 0; i < 3; ++i) world[(up + 1 + i) % 3] = turned[i];
        return world;
    }
    Vec3 fromWorld(const Vec3& world) const {
        Vec3 v;
        for (int i = 0; i < 3; ++i) v[i] = world[(up + 1 + i) % 3];
        return {v.x * cosine + v.y * sine, v.y * cosine - v.x * sine, v.z};
    }
};

}  // namespace raysweep
