/// From a voxel to the brick that holds it.
#pragma once

#include "raysweep/bricks/bricks.h"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace raysweep {

constexpr std::uint32_t kNoBrick = 0xffffffffu;

/// Offset of a voxel in its brick.
inline std::size_t offsetInBrick(const Index3& voxel) {
    return std::size_t((voxel.x & 7) << 6 | (voxel.y & 7) << 3 | (voxel.z & 7));
}

/// The voxel at an offset: offsetInBrick the other way round.
inline Index3 voxelInBrick(int offset) {
    return {offset >> 6, (offset >> 3) & 7, offset & 7};
}

/// A brick's origin one brick outside of the bounding box, where that is periodic, as the one inside that it repeats.
inline Index3 wrapped(const BrickLayout& layout, const Periodic& periodic, Index3 origin) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!periodic[std::size_t(axis)]) continue;
        if (origin[axis] < layout.low[axis]) origin[axis] = layout.high[axis] - kBrickEdge;
        if (origin[axis] >= layout.high[axis]) origin[axis] = layout.low[axis];
    }
    return origin;
}

/// A table over the bounding box where that is not much larger than the bricks, else a hash map.
class BrickMap {
  public:
    explicit BrickMap(const BrickLayout& layout) : low_(layout.low) {
        for (int axis = 0; axis < 3; ++axis) size_[axis] = (layout.high[axis] - layout.low[axis]) / kBrickEdge;
        const double cells = double(size_[0]) * double(size_[1]) * double(size_[2]);
        if (cells < 16.0 * double(layout.brickCount()) + 1e6) dense_.assign(std::size_t(cells), kNoBrick);
        for (std::uint32_t b = 0; b < layout.brickCount(); ++b) {
            const std::uint64_t at = key(layout.origins[b]);
            if (dense_.empty())
                sparse_[at] = b;
            else
                dense_[at] = b;
        }
    }

    /// @return the brick's number, or kNoBrick
    std::uint32_t find(const Index3& voxel) const {
        for (int axis = 0; axis < 3; ++axis)
            if (voxel[axis] < low_[axis] || voxel[axis] >= low_[axis] + kBrickEdge * size_[axis]) return kNoBrick;
        if (!dense_.empty()) return dense_[key(voxel)];
        const auto found = sparse_.find(key(voxel));
        return found == sparse_.end() ? kNoBrick : found->second;
    }

  private:
    std::uint64_t key(const Index3& voxel) const {
        const auto cell = [&](int axis) { return std::uint64_t(voxel[axis] - low_[axis]) / kBrickEdge; };
        return (cell(0) * std::uint64_t(size_[1]) + cell(1)) * std::uint64_t(size_[2]) + cell(2);
    }

    Index3 low_;
    Index3 size_{0};
    std::vector<std::uint32_t> dense_;
    std::unordered_map<std::uint64_t, std::uint32_t> sparse_;
};

}  // namespace raysweep
