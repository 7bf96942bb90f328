/// One sweep: a ray front goes once through the whole volume. Here are its order, what it skips, and its threads; what
/// rays and voxels exchange is in exchange.h.
#pragma once

#include "raysweep/sweep/exchange.h"
#include "raysweep/sweep/ray_front.h"
#include "raysweep/sweep/tile_index.h"
#include "raysweep/volume/brick_map.h"

#include <array>

namespace raysweep {

enum class Interpolation {
    nearest,  ///< a ray meets one voxel per slice; the front is shifted by a fresh random offset in each sweep
    linear    ///< a ray meets the 2x2 voxels around it with bilinear weights
};

/// Bricks and their order along each axis.
struct SweepVolume {
    explicit SweepVolume(BrickLayout bricks) : layout(std::move(bricks)), map(layout), index(indexTiles(layout)) {}

    BrickLayout layout;
    BrickMap map;
    std::array<TileIndex, 3> index;
    Periodic periodic{false, false, false};
};

/// Power of all rays at both ends of a sweep, W.
struct SweepTotals {
    double entered[kMaxChannels] = {0};
    double escaped[kMaxChannels] = {0};
};

/// Sweeps the front through the volume. `step.entering` is what a ray carries when it enters the bounding box of the
/// bricks. With `linear` deposits are left in `fields.fresh` for `settle`. The result has the same bits for any number
/// of threads.
SweepTotals sweep(const SweepVolume& volume, const RayFront& front, Interpolation interpolation,
                  const ExchangeFields& fields, const ExchangeStep& step);

/// Ends a `linear` sweep: see settleBrick.
void settle(const SweepVolume& volume, const ExchangeFields& fields, const ExchangeStep& step);

}  // namespace raysweep
