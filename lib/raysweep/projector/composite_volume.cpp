#include "raysweep/projector/composite_volume.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <string>

namespace raysweep {
namespace {

constexpr int kMostDistance = 255;

std::size_t flat(const Index3& at, const Index3& dims) {
    return (std::size_t(at.x) * std::size_t(dims.y) + std::size_t(at.y)) * std::size_t(dims.z) + std::size_t(at.z);
}

/// Cells that a kept voxel is seen from: its own, and those before it if it is the first in its own.
void markCells(CompositeLayout& layout, const Index3& voxel) {
    Index3 low, high;
    for (int axis = 0; axis < 3; ++axis) {
        high[axis] = (voxel[axis] + 8) >> 2;
        low[axis] = (voxel[axis] + 7) >> 2;
    }
    for (int x = low.x; x <= high.x; ++x)
        for (int y = low.y; y <= high.y; ++y)
            for (int z = low.z; z <= high.z; ++z) layout.cells[flat({x, y, z}, layout.cellDims)] = 0;
}

/// Least of the cells' own number and those of the neighbours plus 1, along one axis: cells grow to distances.
void spreadAlong(CompositeLayout& layout, int axis, int distance) {
    // A cell belongs to `distance` if a cell of less is its neighbour along the axis, in the state before this pass.
    const Index3 dims = layout.cellDims;
    const std::vector<std::uint8_t> before = layout.cells;
    const std::size_t stride =
        axis == 0 ? std::size_t(dims.y) * std::size_t(dims.z) : (axis == 1 ? std::size_t(dims.z) : 1);
    Index3 at;
    for (at.x = 0; at.x < dims.x; ++at.x)
        for (at.y = 0; at.y < dims.y; ++at.y)
            for (at.z = 0; at.z < dims.z; ++at.z) {
                const std::size_t i = flat(at, dims);
                if (before[i] != kMostDistance) continue;
                const bool near = (at[axis] > 0 && before[i - stride] <= distance) ||
                                  (at[axis] + 1 < dims[axis] && before[i + stride] <= distance);
                if (near) layout.cells[i] = std::uint8_t(distance);
            }
}

void measureDistances(CompositeLayout& layout) {
    // More than this is hardly worth a pass over all cells: then rays jump several times.
    constexpr int kFarthest = 16;
    for (int distance = 1; distance <= kFarthest; ++distance)
        for (int axis = 0; axis < 3; ++axis) spreadAlong(layout, axis, distance);
    for (std::uint8_t& cell : layout.cells)
        if (cell == kMostDistance) cell = kFarthest + 1;
}

}  // namespace

std::size_t CompositeLayout::keptVoxels() const {
    std::size_t count = 0;
    for (const VoxelMask& mask : masks)
        for (const std::uint64_t word : mask) count += std::size_t(__builtin_popcountll(word));
    return count;
}

CompositeLayout compositeLayout(const Index3& dims, const std::vector<MaskedBrick>& bricks) {
    return compositeLayout(dims, bricks, bricks);
}

CompositeLayout compositeLayout(const Index3& dims, const std::vector<MaskedBrick>& bricks,
                                const std::vector<MaskedBrick>& seen) {
    CompositeLayout layout;
    layout.dims = dims;
    for (int axis = 0; axis < 3; ++axis) {
        layout.tableDims[axis] = (dims[axis] + 7) / 8 + 2;
        layout.cellDims[axis] = 2 * layout.tableDims[axis];
    }
    layout.table.assign(
        flat({layout.tableDims.x - 1, layout.tableDims.y - 1, layout.tableDims.z - 1}, layout.tableDims) + 1, 0);
    layout.cells.assign(layout.table.size() * 8, kMostDistance);
    layout.origins.push_back(Index3(0));
    layout.masks.push_back({});
    for (const MaskedBrick& brick : bricks) {
        if (brick.mask == VoxelMask{}) continue;
        const Index3 place = {brick.origin.x / 8 + 1, brick.origin.y / 8 + 1, brick.origin.z / 8 + 1};
        layout.table[flat(place, layout.tableDims)] = std::int32_t(layout.origins.size());
        layout.origins.push_back(brick.origin);
        layout.masks.push_back(brick.mask);
    }
    constexpr std::size_t kMostBricks = std::size_t(1) << 22;  // voxels are numbered by 31 bits
    if (layout.brickCount() > kMostBricks)
        throw InvalidArgument("the volume has " + std::to_string(layout.brickCount() - 1) +
                              " bricks of 8x8x8 voxels; at most " + std::to_string(kMostBricks - 1) +
                              " are possible; make it coarser");
    for (const MaskedBrick& brick : seen)
        for (int i = 0; i < 512; ++i) {
            const Index3 within(i >> 6, i >> 3 & 7, i & 7);
            if (isSet(brick.mask, within.x, within.y, within.z)) markCells(layout, brick.origin + within);
        }
    measureDistances(layout);
    return layout;
}

}  // namespace raysweep
