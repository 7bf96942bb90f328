/// A brick with what is around it.
#pragma once

#include "raysweep/bricks/brick_map.h"
#include "raysweep/bricks/bricks.h"

namespace raysweep {

/// A brick's values and those of the voxels around it (where the volume repeats, of its other end); 0 where there are
/// none.
template <class T>
struct PaddedBrick {
    T value[kBrickEdge + 2][kBrickEdge + 2][kBrickEdge + 2] = {};

    /// @param valuesOf gives the 512 values of a brick by its number, or null if it has none
    template <class ValuesOf>
    PaddedBrick(const BrickLayout& layout, const BrickMap& map, const Periodic& periodic, std::size_t b,
                const ValuesOf& valuesOf) {
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k) {
                    const Index3 side(i, j, k);
                    const std::uint32_t neighbour =
                        map.find(wrapped(layout, periodic, layout.origins[b] + side * kBrickEdge));
                    const T* const from = neighbour == kNoBrick ? nullptr : valuesOf(neighbour);
                    if (from) copyFrom(from, side);
                }
    }

    /// Value of voxel (x,y,z) of the brick, each in [-1, 8].
    const T& at(int x, int y, int z) const { return value[x + 1][y + 1][z + 1]; }

    /// Calls `visit(x, y, z)` for voxel `i` (an offset) of the brick and its 26 neighbours.
    template <class Visit>
    static void forEachAround(int i, const Visit& visit) {
        const int x = i >> 6, y = (i >> 3) & 7, z = i & 7;
        for (int dx = -1; dx <= 1; ++dx)
            for (int dy = -1; dy <= 1; ++dy)
                for (int dz = -1; dz <= 1; ++dz) visit(x + dx, y + dy, z + dz);
    }

  private:
    /// Takes the voxels of the neighbour on `side` that touch the brick.
    void copyFrom(const T* from, const Index3& side) {
        const auto first = [&](int axis) { return side[axis] < 0 ? kBrickEdge - 1 : 0; };
        const auto last = [&](int axis) { return side[axis] > 0 ? 0 : kBrickEdge - 1; };
        const Index3 to = side * kBrickEdge + Index3(1);
        for (int x = first(0); x <= last(0); ++x)
            for (int y = first(1); y <= last(1); ++y)
                for (int z = first(2); z <= last(2); ++z)
                    value[x + to.x][y + to.y][z + to.z] = from[x << 6 | y << 3 | z];
    }
};

}  // namespace raysweep
