/// A ray front cut into tiles of rays, each with the bricks it meets. Rays do not touch each other, so a tile is
/// stepped through the whole volume on its own, and only tiles that meet a brick are made (all, in a volume that is
/// periodic along the sweep's axis).
#pragma once

#include "raysweep/sweep/ray_front.h"
#include "raysweep/sweep/tile_index.h"

#include <cstdint>
#include <vector>

namespace raysweep {

// A tile has at most 512 x 32 rays. Few rows, so that there are tiles for all threads; many columns, because a brick
// that is cut between two columns costs more than one cut between two rows. Measured in bench/runtime.
constexpr int kTileColumnBits = 9;
constexpr int kTileRowBits = 5;

/// A brick as a front meets it.
struct BrickVisit {
    std::uint32_t brick;
    int column, row;  ///< lateral coordinates of its low corner (of its image, in a periodic volume)
    int step;         ///< slice number, in the order of travel, of its first slice
};

struct RayTile {
    RayRange columns, rows;             ///< lattice coordinates of its rays
    const BrickVisit* begin = nullptr;  ///< in the order of travel: no ray meets a brick before one upwind of it
    const BrickVisit* end = nullptr;
};

/// The tiles of a front that meet bricks.
struct RayTiles {
    RayTiles() = default;
    RayTiles(RayTiles&&) = default;      // tiles point into `visits`, which keeps its place when moved,
    RayTiles(const RayTiles&) = delete;  // but not when copied
    RayTiles& operator=(const RayTiles&) = delete;

    std::vector<RayTile> tiles;
    std::vector<BrickVisit> visits;
    /// Tiles [colours[c], colours[c+1]) share no brick: where tiles may meet the same voxel (`linear`), those may write
    /// at the same time.
    std::vector<std::size_t> colours;
};

RayTiles cutIntoTiles(const RayFront& front, const BrickLayout& layout, const TileIndex& index);

}  // namespace raysweep
