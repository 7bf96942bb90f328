/// Which bricks a sweep along an axis meets, slice by slice: empty space is not in the list, so it costs nothing.
#pragma once

#include "raysweep/bricks/brick_map.h"
#include "raysweep/bricks/bricks.h"
#include "raysweep/sweep/axis.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace raysweep {

/// Bricks ordered by (layer, row, column) of one sweep axis; a layer is eight slices thick.
class BrickIndex {
  public:
    struct Entry {
        std::uint32_t brick;  ///< kNoBrick for a margin
        int column;           ///< voxel coordinate of its low corner
    };
    /// A row of bricks.
    struct Row {
        int layer, row;          ///< voxel coordinates of its low corner
        std::size_t first, end;  ///< in `entries`
    };

    /// @param margins origins of empty bricks that are to be met as well
    BrickIndex(const std::vector<Index3>& origins, const std::vector<Index3>& margins, const SweepAxis& axis);

    const std::vector<Entry>& entries() const { return entries_; }
    /// Ascending in (layer, row).
    const std::vector<Row>& rows() const { return rows_; }
    struct Layer {
        int layer;
        std::size_t first, end;  ///< in `rows`
    };
    /// Ascending.
    const std::vector<Layer>& layers() const { return layers_; }
    /// Bricks and margins by the coordinate where their layer begins, and their row (of any layer).
    const std::map<int, std::size_t>& countByLayer() const { return countByLayer_; }
    const std::map<int, std::size_t>& countByRow() const { return countByRow_; }
    /// Layers [first, end) that begin in [low, high).
    std::pair<std::size_t, std::size_t> findLayers(int low, int high) const;
    /// Rows [first, end) of a layer that begin in [low, high).
    std::pair<std::size_t, std::size_t> findRows(const Layer& layer, int low, int high) const;

  private:
    std::vector<Entry> entries_;
    std::vector<Row> rows_;
    std::vector<Layer> layers_;
    std::map<int, std::size_t> countByLayer_, countByRow_;
};

/// Origins of the empty bricks that have a brick next to them on the upper side of the axis' row, column or both: rays
/// that pass there meet with their 2x2 voxels some of that brick's.
std::vector<Index3> marginsBelow(const BrickLayout& layout, const BrickMap& map, const Periodic& periodic,
                                 const SweepAxis& axis);

}  // namespace raysweep
