/// A brick with what is around it.
#pragma once

#include "raysweep/bricks/brick_map.h"
#include "raysweep/bricks/sides.h"

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
        forEachSide([&](const Index3& side) {
            const std::uint32_t neighbour = map.find(wrapped(layout, periodic, layout.origins[b] + side * kBrickEdge));
            const T* const from = neighbour == kNoBrick ? nullptr : valuesOf(neighbour);
            if (from) copyFrom(from, side);
        });
    }

    /// Value of voxel (x,y,z) of the brick, each in [-1, 8].
    const T& at(int x, int y, int z) const { return value[x + 1][y + 1][z + 1]; }

    /// Calls `visit(x, y, z)` for voxel `i` (an offset) of the brick and its 26 neighbours.
    template <class Visit>
    static void forEachAround(int i, const Visit& visit) {
        const Index3 voxel = voxelInBrick(i);
        forEachSide([&](const Index3& side) { visit(voxel.x + side.x, voxel.y + side.y, voxel.z + side.z); });
    }

  private:
    /// Takes the voxels of the neighbour on `side` that touch the brick.
    void copyFrom(const T* from, const Index3& side) {
        const Index3 to = side * kBrickEdge + Index3(1);
        forEachTouching(side * -1, [&](const Index3& voxel) {
            value[voxel.x + to.x][voxel.y + to.y][voxel.z + to.z] = from[offsetInBrick(voxel)];
        });
    }
};

}  // namespace raysweep
