#pragma once

#include "raysweep/core/types.h"

#include <cmath>

namespace raysweep {

inline bool isFinite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace raysweep
