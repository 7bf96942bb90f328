#include "raysweep/bricks/gradient.h"

namespace raysweep {

Vec3 gradientAt(const PaddedBrick<float>& brick, int x, int y, int z) {
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

}  // namespace raysweep
