/// Gradients on bricks.
#pragma once

#include "raysweep/bricks/padded_brick.h"

namespace raysweep {

/// Gradient at voxel (x,y,z), each in [0,7], per voxel along each axis of index space: central differences, averaged
/// over the 3x3 lines around the voxel with weights 1 2 1 (Sobel). The averaging tilts the normals of a staircase
/// towards those of the wall that it stands for. Outside all bricks is empty space, so a solid that ends with the
/// volume has a surface there.
Vec3 gradientAt(const PaddedBrick<float>& brick, int x, int y, int z);

/// Takes a gradient from index to world space: 1/voxel to 1/world unit.
inline Vec3 worldGradient(const Vec3& inIndex, const Matrix3& indexFromWorld) {
    // d/dworld = indexFromWorld * d/dindex, in the row-vector convention.
    return inIndex * indexFromWorld.transposed();
}

}  // namespace raysweep
