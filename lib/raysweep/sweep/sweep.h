/// One sweep: a ray front goes once through the whole volume. Here are its order, what it skips, and its threads; what
/// rays and voxels exchange is in exchange.h.
#pragma once

#include "raysweep/sweep/exchange.h"
#include "raysweep/sweep/sweep_volume.h"

#include <vector>

namespace raysweep {

/// Sweeps the beams through the volume together. They must share their axis and the sign of travel along all three;
/// a volume that is periodic takes one beam at a time. `entering` is what a ray carries when it enters the bounding box
/// of the bricks. With `linear` deposits are left in `fields.fresh` for `settle`. The result has the same bits for any
/// number of threads.
/// @return what the rays of each beam carried at both ends
std::vector<RaySums> sweep(const SweepVolume& volume, const std::vector<Beam>& beams, Interpolation interpolation,
                           const ExchangeFields& fields, const ExchangeConstants& constants);

/// Ends a `linear` sweep: see settleBrick.
void settle(const SweepVolume& volume, const std::vector<Beam>& beams, const ExchangeFields& fields,
            const ExchangeConstants& constants);

}  // namespace raysweep
