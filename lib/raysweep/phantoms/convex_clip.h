/// The part of a cube that half-spaces leave.
#pragma once

#include "raysweep/core/types.h"

#include <vector>

namespace raysweep {

/// The points p with p.normal <= offset; the normal has length 1.
struct HalfSpace {
    Vec3 normal;
    double offset;
};

/// Volume of the points of the cube [-1/2,1/2]³ about `center` that lie in all `spaces`; exact but for rounding.
double volumeInCube(const Vec3& center, const std::vector<HalfSpace>& spaces);

}  // namespace raysweep
