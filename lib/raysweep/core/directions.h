/// Directions that follow from others.
#pragma once

#include "raysweep/core/types.h"

#include <cmath>

namespace raysweep {

/// An axis of the world that is well away from a direction of length 1: what makes a plane with it.
inline Vec3 axisAside(const Vec3& direction) {
    return std::abs(direction.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
}

}  // namespace raysweep
