#include "raysweep/sweep/tile_index.h"

#include <algorithm>
#include <numeric>

namespace raysweep {

TileIndex::TileIndex(const BrickLayout& layout, const SweepAxis& axis) : bricks_(layout.brickCount()) {
    const std::vector<Index3>& at = layout.origins;
    std::iota(bricks_.begin(), bricks_.end(), 0u);
    std::sort(bricks_.begin(), bricks_.end(), [&](std::uint32_t a, std::uint32_t b) {
        for (const int key : {axis.major, axis.row, axis.column})
            if (at[a][key] != at[b][key]) return at[a][key] < at[b][key];
        return false;
    });
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
        const Index3& here = at[bricks_[i]];
        const Index3& before = at[bricks_[i > 0 ? i - 1 : 0]];
        const bool newLayer = i == 0 || here[axis.major] != before[axis.major];
        const bool newRow = newLayer || here[axis.row] != before[axis.row];
        if (newLayer) layers_.push_back(int(rows_.size()));
        if (newRow) rows_.push_back(int(i));
    }
    layers_.push_back(int(rows_.size()));
    rows_.push_back(int(bricks_.size()));
}

std::array<TileIndex, 3> indexTiles(const BrickLayout& layout) {
    return {TileIndex(layout, sweepAxis(0)), TileIndex(layout, sweepAxis(1)), TileIndex(layout, sweepAxis(2))};
}

}  // namespace raysweep
