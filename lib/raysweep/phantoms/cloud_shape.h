/// The cloud of phantom.h as a density in space, before it is sampled on a grid.
#pragma once

#include "raysweep/core/types.h"

#include <cstdint>
#include <vector>

namespace raysweep {

struct CloudPuff {
    Vec3 centre;
    double radius;
};

/// Balls, big ones on the base and smaller ones on top of them. Lengths in units of about half the cloud's width.
struct CloudShape {
    std::vector<CloudPuff> puffs;
    double base = 0;           ///< height below which nothing is
    Vec3 low, high;            ///< box of what is there, found by samples
    Vec3 outerLow, outerHigh;  ///< box outside of which the density is surely 0
    std::uint32_t seed = 1;
};

CloudShape makeCloudShape(std::uint32_t seed);

/// The puffs that could make the density within `reach` of `p` differ from 0.
std::vector<CloudPuff> puffsNear(const CloudShape& shape, const Vec3& p, double reach);

/// Density in [0,1] at `p`; `puffs` are those near it.
double cloudDensity(const CloudShape& shape, const std::vector<CloudPuff>& puffs, const Vec3& p);

}  // namespace raysweep
