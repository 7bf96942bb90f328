/// Three sweep axes: the major axis of a direction, and how its slices lie in a brick.
#pragma once

#include "raysweep/core/types.h"

namespace raysweep {

/// Slices are perpendicular to `major`. In a slice, rows follow each other along `row` (v) and the voxels of a row
/// along `column` (u). Columns are contiguous in a brick for the x and y axes; for z a brick is transposed as it is
/// visited.
struct SweepAxis {
    int major = 0, row = 1, column = 2;
    int sliceStride = 64, rowStride = 8;  ///< in a brick (after transposing, for z)
    bool transposed = false;
};

inline SweepAxis sweepAxis(int major) {
    switch (major) {
        case 0:
            return {0, 1, 2, 64, 8, false};
        case 1:
            return {1, 0, 2, 8, 64, false};
        default:
            return {2, 0, 1, 8, 64, true};
    }
}

/// Directions of one class (in index space) have their major axis in common, and the signs of travel along it and along
/// its rows: their beams meet rows of bricks in one order, so that they can go together.
constexpr int kDirectionClasses = 12;
inline int directionClass(const Vec3& direction) {
    const SweepAxis axis = sweepAxis(majorAxis(direction));
    return axis.major * 4 + (direction[axis.major] < 0 ? 2 : 0) + (direction[axis.row] < 0 ? 1 : 0);
}

}  // namespace raysweep
