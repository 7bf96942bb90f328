/// Small bright parts of a sky map, as suns.
#pragma once

#include "raysweep/scene/lat_long.h"

#include <vector>

namespace raysweep {

/// Light from somewhere on the sphere: sums over pixels, weighted with their power.
struct LightMoments {
    Imath::Color3<double> irradiance{0, 0, 0};  ///< integral of radiance over solid angle, W m^-2
    Vec3 first{0}, second{0};  ///< of the directions towards them and of the squares of their components

    double power() const { return (irradiance.x + irradiance.y + irradiance.z) / 3; }
    /// Adds a pixel that is about `extent` radians wide and high.
    void add(const Imath::Color3<double>& part, const Vec3& towards, double extent);
    LightMoments& operator+=(const LightMoments& other);
    Vec3 mean() const { return first / power(); }
    /// Variance of each component of the direction.
    Vec3 variance() const;
    /// Root of the mean squared distance from the mean direction, about an angle in radians.
    double spread() const;
};

/// Divides `cells` into at most `most` groups, none wider than can be helped, and leaves out those that are too wide to
/// pass for a sun.
/// @param groupOf receives the number of each cell's group, -1 for those without light and those that are left out
/// @return moments of the groups
std::vector<LightMoments> groupIntoSuns(const std::vector<LightMoments>& cells, int most, std::vector<int>& groupOf);

}  // namespace raysweep
