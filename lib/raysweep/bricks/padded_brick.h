/// A brick with what is around it.
#pragma once

#include "raysweep/bricks/brick_map.h"
#include "raysweep/bricks/sides.h"

namespace raysweep {

/// A brick's values and those of the voxels around it, `kPad` deep (where the volume repeats, of its other end); 0
/// where there are none.
template <class T, int kPad = 1>
struct PaddedBrick {
    static_assert(kPad >= 1 && kPad <= kBrickEdge, "only the bricks next to it are looked at");
    static constexpr int kWidth = kBrickEdge + 2 * kPad;
    T value[kWidth][kWidth][kWidth] = {};

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

    /// Value of voxel (x,y,z) of the brick, each in [-kPad, 7 + kPad].
    const T& at(int x, int y, int z) const { return value[x + kPad][y + kPad][z + kPad]; }

    /// All values, in no matter what order.
    struct Values {
        T *first, *last;
        T* begin() const { return first; }
        T* end() const { return last; }
    };
    Values values() {
        T* const first = &value[0][0][0];
        return {first, first + kWidth * kWidth * kWidth};
    }

    /// Calls `visit(x, y, z)` for voxel `i` (an offset) of the brick and its 26 neighbours.
    template <class Visit>
    static void forEachAround(int i, const Visit& visit) {
        const Index3 voxel = voxelInBrick(i);
        forEachSide([&](const Index3& side) { visit(voxel.x + side.x, voxel.y + side.y, voxel.z + side.z); });
    }

  private:
    /// Takes the voxels of the neighbour on `side` that are near the brick.
    void copyFrom(const T* from, const Index3& side) {
        const auto first = [&](int axis) { return side[axis] < 0 ? kBrickEdge - kPad : 0; };
        const auto last = [&](int axis) { return side[axis] > 0 ? kPad : kBrickEdge; };
        const Index3 to = side * kBrickEdge + Index3(kPad);
        for (int x = first(0); x < last(0); ++x)
            for (int y = first(1); y < last(1); ++y)
                for (int z = first(2); z < last(2); ++z)
                    value[x + to.x][y + to.y][z + to.z] = from[offsetInBrick(Index3(x, y, z))];
    }
};

}  // namespace raysweep
