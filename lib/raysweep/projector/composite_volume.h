/// Extinction and colour in sparse bricks, laid out for rays that meet few of them.
#pragma once

#include "raysweep/core/parallel.h"
#include "raysweep/core/types.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace raysweep {

/// What a voxel is made of; also a derivative with respect to it.
struct alignas(16) CompositeVoxel {
    float extinction = 0;                ///< 1 / edge of a voxel
    float red = 0, green = 0, blue = 0;  ///< linear light
};

/// Voxels of a brick of 8x8x8: bit y << 3 | z of word x.
using VoxelMask = std::array<std::uint64_t, 8>;

inline bool isSet(const VoxelMask& mask, int x, int y, int z) {
    return (mask[std::size_t(x)] >> (y << 3 | z) & 1) != 0;
}

/// Where the bricks are, and how far it is to them. Voxels of all bricks are one array, brick after brick, voxel
/// (x,y,z) at (x << 6) | (y << 3) | z; brick 0 is one that is empty, and stands for all that is not kept.
struct CompositeLayout {
    Index3 dims{0};                   ///< voxels along x, y, z
    Index3 tableDims{0};              ///< of `table`: bricks that cover the volume, and one around them
    std::vector<std::int32_t> table;  ///< number of the brick at (x >> 3) + 1, ...; z contiguous; 0: none
    std::vector<Index3> origins;      ///< low corner of each brick, voxels; the first means nothing
    std::vector<VoxelMask> masks;     ///< voxels of each brick that are kept; others are 0 and stay so
    Index3 cellDims{0};               ///< of `cells`: 4x4x4 voxels each, that cover the table
    std::vector<std::uint8_t> cells;  ///< 0: a sample between the cell's voxels and the next may see a voxel that is
                                      ///< kept; else the distance to the next such cell (its largest coordinate)

    std::size_t brickCount() const { return origins.size(); }  ///< with the empty one
    std::size_t voxelCount() const { return origins.size() * 512; }
    std::size_t keptVoxels() const;
    /// Whether the voxel at an index is kept.
    bool keeps(std::size_t voxel) const {
        return isSet(masks[voxel >> 9], int(voxel >> 6 & 7), int(voxel >> 3 & 7), int(voxel & 7));
    }
    /// Index of a voxel, which may lie one outside of the volume.
    std::size_t voxel(const Index3& at) const {
        const int brick =
            table[(std::size_t((at.x >> 3) + 1) * std::size_t(tableDims.y) + std::size_t((at.y >> 3) + 1)) *
                      std::size_t(tableDims.z) +
                  std::size_t((at.z >> 3) + 1)];
        return std::size_t(brick) << 9 | std::size_t((at.x & 7) << 6 | (at.y & 7) << 3 | (at.z & 7));
    }
};

/// Calls `body(voxel's index, its place)` for all voxels that are kept, several bricks at a time.
template <class Body>
void forKept(const CompositeLayout& layout, const Body& body) {
    constexpr std::size_t kTogether = 4;  // bricks
    parallelFor(
        layout.brickCount() - 1,
        [&](std::size_t n) {
            const std::size_t b = n + 1;
            for (int i = 0; i < 512; ++i) {
                const Index3 within(i >> 6, i >> 3 & 7, i & 7);
                if (isSet(layout.masks[b], within.x, within.y, within.z))
                    body(b * 512 + std::size_t(i), layout.origins[b] + within);
            }
        },
        kTogether);
}

/// A brick and those of its voxels that are to be kept.
struct MaskedBrick {
    Index3 origin;  ///< low corner, multiples of 8
    VoxelMask mask;
};

/// @param bricks at most one for each place; those with empty masks are left out
/// @param seen bricks of those voxels that may have extinction: rays take samples near these only
/// @throw InvalidArgument for 2^22 bricks and more
CompositeLayout compositeLayout(const Index3& dims, const std::vector<MaskedBrick>& bricks,
                                const std::vector<MaskedBrick>& seen);

/// All that is kept is seen.
CompositeLayout compositeLayout(const Index3& dims, const std::vector<MaskedBrick>& bricks);

}  // namespace raysweep
