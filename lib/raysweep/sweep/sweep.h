/// One sweep: a ray front goes once through the whole volume. Here are its order, what it skips, and its threads; what
/// rays and voxels exchange is in exchange.h.
#pragma once

#include "raysweep/bricks/brick_map.h"
#include "raysweep/sweep/brick_index.h"
#include "raysweep/sweep/exchange.h"

#include <array>
#include <optional>
#include <vector>

namespace raysweep {

enum class Interpolation {
    nearest,  ///< a ray meets one voxel per slice; the front is shifted by a fresh random offset in each sweep
    linear    ///< a ray meets the 2x2 voxels around it with bilinear weights
};

/// Bricks and their order along each axis.
struct SweepVolume {
    explicit SweepVolume(BrickLayout bricks, Periodic repeats = {false, false, false});

    /// The order with the margins that `linear` needs. Not to be called by two threads at once.
    const BrickIndex& indexFor(int axis, Interpolation interpolation) const;

    BrickLayout layout;
    BrickMap map;
    Periodic periodic;

  private:
    mutable std::array<std::optional<BrickIndex>, 3> index_[2];
};

/// Sweeps the beams through the volume together. They must share their axis and the sign of travel along all three;
/// a volume that is periodic takes one beam at a time. `entering` is what a ray carries when it enters the bounding box
/// of the bricks. With `linear` deposits are left in `fields.fresh` for `settle`. The result has the same bits for any
/// number of threads.
/// @return what the rays of each beam carried at both ends
std::vector<RaySums> sweep(const SweepVolume& volume, const std::vector<Beam>& beams, Interpolation interpolation,
                           const ExchangeFields& fields, const ExchangeStep& step);

/// Ends a `linear` sweep: see settleBrick.
void settle(const SweepVolume& volume, const std::vector<Beam>& beams, const ExchangeFields& fields,
            const ExchangeStep& step);

}  // namespace raysweep
