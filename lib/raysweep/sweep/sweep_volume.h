/// The bricks that sweeps go through, and the order in which they meet them.
#pragma once

#include "raysweep/bricks/brick_map.h"
#include "raysweep/sweep/brick_index.h"
#include "raysweep/sweep/interpolation.h"

#include <array>
#include <optional>

namespace raysweep {

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

}  // namespace raysweep
