/// A brick's neighbours, and its voxels that touch them.
#pragma once

#include "raysweep/bricks/bricks.h"

namespace raysweep {

/// Calls `visit(side)` for all `side` with components of -1, 0 and 1: 26 neighbours and, as (0,0,0), the thing itself.
template <class Visit>
void forEachSide(const Visit& visit) {
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            for (int k = -1; k <= 1; ++k) visit(Index3(i, j, k));
}

/// Calls `visit(voxel)`, each component in [0,7], for the voxels of a brick that touch its neighbour on `side`.
template <class Visit>
void forEachTouching(const Index3& side, const Visit& visit) {
    const auto first = [&](int axis) { return side[axis] > 0 ? kBrickEdge - 1 : 0; };
    const auto last = [&](int axis) { return side[axis] < 0 ? 0 : kBrickEdge - 1; };
    for (int x = first(0); x <= last(0); ++x)
        for (int y = first(1); y <= last(1); ++y)
            for (int z = first(2); z <= last(2); ++z) visit(Index3(x, y, z));
}

}  // namespace raysweep
