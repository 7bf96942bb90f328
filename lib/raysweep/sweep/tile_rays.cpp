#include "raysweep/sweep/tile_rays.h"

#include <algorithm>

namespace raysweep {

TileRays::TileRays(const RayTile& tile, int channels, bool furnace)
    : columns_(tile.columns.size()),
      rows_(tile.rows.size()),
      channels_(channels),
      furnace_(furnace),
      stride_(std::size_t(columns_ + 2 * kPad)),
      plane_(stride_ * std::size_t(rows_)),
      energy_(plane_ * std::size_t(channels + (furnace ? 2 : 0)), 0.0f) {}

void TileRays::enter(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, const ExchangeStep& step,
                     TileSums& sums) {
    if (furnace_) std::fill_n(energy_.end() - std::ptrdiff_t(plane_), plane_, kLongAgo);
    for (int r = 0; r < rows_; ++r) {
        const RayRange enters = raysThatEnter(front, tile.rows.begin + r);
        const int begin = std::max(enters.begin - tile.columns.begin, 0);
        const int end = std::min(enters.end - tile.columns.begin, columns_);
        if (end <= begin) continue;
        sums.rays += end - begin;
        for (int c = 0; c < fields.channels; ++c) {
            float* const rays = row(r) + std::size_t(c) * plane_;
            std::fill(rays + begin, rays + end, step.entering[c]);
        }
    }
    if (fields.arriving) arrive(front, tile, *fields.arriving, sums);
}

void TileRays::leave(const RayFront& front, const RayTile& tile, const ExchangeFields& fields, TileSums& sums) {
    if (fields.leaving) goOn(front, tile, *fields.leaving);
    for (int c = 0; c < fields.channels; ++c)
        for (int r = 0; r < rows_; ++r) {
            const float* const rays = row(r) + std::size_t(c) * plane_;
            double sum = 0;
            for (int u = 0; u < columns_; ++u) sum += double(rays[u]);
            sums.escaped[c] += sum;
        }
}

/// Rays that were inside in the slice before the first come from the repetition before.
void TileRays::arrive(const RayFront& front, const RayTile& tile, CrossingRays& arriving, TileSums& sums) {
    const auto inBoth = [&](const Lateral& lateral, const RayRange& ofTile) {
        const RayRange before = raysInside(front, lateral, -1), now = raysInside(front, lateral, 0);
        return RayRange{std::max({before.begin, now.begin, ofTile.begin}), std::min({before.end, now.end, ofTile.end})};
    };
    const RayRange columns = inBoth(front.column, tile.columns), rows = inBoth(front.row, tile.rows);
    for (int r = rows.begin; r < rows.end; ++r) {
        sums.rays -= columns.size();
        const int local = r - tile.rows.begin;
        for (int u = columns.begin; furnace_ && !arriving.furnace.empty() && u < columns.end; ++u) {
            furnaceRow(local)[u - tile.columns.begin] = arriving.furnaceAt(r, u);
            sliceRow(local)[u - tile.columns.begin] = arriving.sliceAt(r, u);
        }
        for (int c = 0; c < arriving.channels; ++c)
            for (int u = columns.begin; u < columns.end; ++u)
                row(local)[std::size_t(c) * plane_ + std::size_t(u - tile.columns.begin)] = arriving.at(c, r, u);
    }
}

/// Hands over the rays that are inside in the slice after the last.
void TileRays::goOn(const RayFront& front, const RayTile& tile, CrossingRays& leaving) {
    for (int r = 0; r < rows_; ++r) {
        const int rowThere = rayInNextRepetition(front, front.row, tile.rows.begin + r);
        if (rowThere < leaving.rows.begin || rowThere >= leaving.rows.end) continue;
        for (int u = 0; u < columns_; ++u) {
            const int there = rayInNextRepetition(front, front.column, tile.columns.begin + u);
            if (there < leaving.columns.begin || there >= leaving.columns.end) continue;
            if (furnace_) {
                leaving.furnaceAt(rowThere, there) = furnaceRow(r)[u];
                leaving.sliceAt(rowThere, there) = sliceRow(r)[u] - float(front.slices);
            }
            for (int c = 0; c < leaving.channels; ++c) {
                float& ray = row(r)[std::size_t(c) * plane_ + std::size_t(u)];
                leaving.at(c, rowThere, there) = ray;
                ray = 0;
            }
        }
    }
}

}  // namespace raysweep
