/// Which bricks a sweep along an axis meets, slice by slice: empty space is not in the list, so it costs nothing.
#pragma once

#include "raysweep/sweep/axis.h"
#include "raysweep/volume/bricks.h"

#include <array>
#include <cstdint>
#include <vector>

namespace raysweep {

/// The bricks ordered by (layer, row, column) of one sweep axis; a layer is eight slices thick.
class TileIndex {
  public:
    TileIndex(const BrickLayout& layout, const SweepAxis& axis);

    /// Calls `visit(brick)` for every brick, layers, rows and columns each ascending or, where its flag is
    /// false, descending.
    template <class Visit>
    void forEach(bool layersUp, bool rowsUp, bool columnsUp, const Visit& visit) const {
        forEachIn(layers_, layersUp, {0, int(layers_.size()) - 1}, [&](Range rows) {
            forEachIn(rows_, rowsUp, rows, [&](Range columns) {
                const int count = columns.end - columns.begin;
                for (int i = 0; i < count; ++i)
                    visit(bricks_[std::size_t(columnsUp ? columns.begin + i : columns.end - 1 - i)]);
            });
        });
    }

  private:
    struct Range {
        int begin, end;
    };
    template <class Visit>
    static void forEachIn(const std::vector<int>& starts, bool up, Range range, const Visit& visit) {
        const int count = range.end - range.begin;
        for (int i = 0; i < count; ++i) {
            const int at = up ? range.begin + i : range.end - 1 - i;
            visit(Range{starts[std::size_t(at)], starts[std::size_t(at) + 1]});
        }
    }

    std::vector<std::uint32_t> bricks_;
    std::vector<int> rows_;    ///< first brick of each row, and the end
    std::vector<int> layers_;  ///< first row of each layer, and the end
};

/// One index per major axis.
std::array<TileIndex, 3> indexTiles(const BrickLayout& layout);

}  // namespace raysweep
