/// Gradients on bricks.
#pragma once

#include "raysweep/bricks/padded_brick.h"

namespace raysweep {

/// Gradient at voxel (x,y,z), each in [0,7], per voxel along each axis of index space: central differences, averaged
/// over the 3x3 lines around the voxel with weights 1 2 1 (Sobel). The averaging tilts the normals of a staircase
/// towards those of the wall that it stands for. Outside all bricks is empty space, so a solid that ends with the
/// volume has a surface there.
template <int kPad>
Vec3 gradientAt(const PaddedBrick<float, kPad>& brick, int x, int y, int z) {
    constexpr int kWeight[3] = {1, 2, 1};
    Vec3 sum(0);
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j) {
            const double weight = kWeight[i + 1] * kWeight[j + 1];
            sum.x += weight * (double(brick.at(x + 1, y + i, z + j)) - double(brick.at(x - 1, y + i, z + j)));
            sum.y += weight * (double(brick.at(x + i, y + 1, z + j)) - double(brick.at(x + i, y - 1, z + j)));
            sum.z += weight * (double(brick.at(x + i, y + j, z + 1)) - double(brick.at(x + i, y + j, z - 1)));
        }
    return sum / 32;  // 16 of weight, 2 voxels of distance
}

/// Takes a gradient from index to world space: 1/voxel to 1/world unit.
inline Vec3 worldGradient(const Vec3& inIndex, const Matrix3& indexFromWorld) {
    // d/dworld = indexFromWorld * d/dindex, in the row-vector convention.
    return inIndex * indexFromWorld.transposed();
}

}  // namespace raysweep
