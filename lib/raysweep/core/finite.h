#pragma once

#include "raysweep/core/types.h"

#include <algorithm>
#include <cmath>

namespace raysweep {

inline bool isFinite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// True if `v` has a direction: finite, and not 0.
inline bool isDirection(const Vec3& v) {
    return isFinite(v) && (v.x != 0 || v.y != 0 || v.z != 0);
}

/// `v` with the length 1. Lengths whose squares no number can hold make no difference.
inline Vec3 unitVector(const Vec3& v) {
    constexpr double kLong = 1e100;
    const double most = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return (most > kLong || most < 1 / kLong ? v / most : v).normalized();
}

}  // namespace raysweep
