/// The rays of one tile while they go through the volume.
#pragma once

#include "raysweep/sweep/exchange.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace raysweep {

/// Energies of a tile's rays, in rows that are padded on both sides by what a brick may overhang.
class TileRays {
  public:
    /// @param furnace rays carry the local furnace as well
    TileRays(const RayTile& tile, int channels, bool furnace);

    /// Rays of a row of the tile; the next channel's are `planeStride` on.
    float* row(int row) { return energy_.data() + std::size_t(row) * stride_ + kPad; }
    /// f of the rays of a row, and the slice in which they were in a solid last.
    float* furnaceRow(int row) { return this->row(row) + std::size_t(channels_) * plane_; }
    float* sliceRow(int row) { return this->row(row) + std::size_t(channels_ + 1) * plane_; }
    int columns() const { return columns_; }
    int rows() const { return rows_; }
    std::size_t planeStride() const { return plane_; }

    /// Gives every ray that enters the volume its power; counts them.
    void enter(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
               TileSums& sums);
    /// Sums what the rays carry at the end.
    void leave(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, TileSums& sums);

  private:
    static constexpr int kPad = 16;

    void arrive(const RayFront& front, const RayTile& tile, CrossingRays& arriving, TileSums& sums);
    void goOn(const RayFront& front, const RayTile& tile, CrossingRays& leaving);

    int columns_, rows_, channels_;
    bool furnace_;
    std::size_t stride_, plane_;
    std::vector<float> energy_;
};

/// How the eight slices of a visited brick lie over a tile's rays, in the order of travel.
struct Overlap {
    int slice[kBrickEdge];                    ///< slice of the brick
    int column[kBrickEdge];                   ///< tile column of the ray at the slice's first column
    int row[kBrickEdge];                      ///< tile row of the ray at the slice's first row
    int firstRow = kBrickEdge, lastRow = -1;  ///< rows of the brick met in any slice
    bool clipped = false;                     ///< some column lies outside the tile

    Overlap(const RayFront& front, const RayTile& tile, const BrickVisit& visit) {
        const int columns = tile.columns.size(), rows = tile.rows.size();
        for (int j = 0; j < kBrickEdge; ++j) {
            slice[j] = front.ascending ? j : kBrickEdge - 1 - j;
            column[j] = visit.column - front.column.shift(visit.step + j) - tile.columns.begin;
            row[j] = visit.row - front.row.shift(visit.step + j) - tile.rows.begin;
            clipped = clipped || column[j] < front.reach || column[j] + kBrickEdge > columns;
            firstRow = std::min(firstRow, std::max(0, -row[j]));
            lastRow = std::max(lastRow, std::min(kBrickEdge, rows - row[j] + front.reach) - 1);
        }
    }

    /// Row r of the brick is met in all slices and all columns.
    bool meetsWholeRow(int r, int rows) const {
        const int low = std::min(row[0], row[kBrickEdge - 1]), high = std::max(row[0], row[kBrickEdge - 1]);
        return !clipped && low + r >= 0 && high + r < rows;
    }

    /// Slice j meets none of the tile's `columns`.
    bool missesColumns(int j, int columns, int reach) const {
        return column[j] + kBrickEdge <= 0 || column[j] - reach >= columns;
    }
};

}  // namespace raysweep
