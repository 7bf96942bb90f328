#include "raysweep/sweep/sweep_volume.h"

#include <utility>
#include <vector>

namespace raysweep {

SweepVolume::SweepVolume(BrickLayout bricks, Periodic repeats)
    : layout(std::move(bricks)), map(layout), periodic(repeats) {}

const BrickIndex& SweepVolume::indexFor(int major, Interpolation interpolation) const {
    const bool linear = interpolation == Interpolation::linear;
    std::optional<BrickIndex>& index = index_[linear ? 1 : 0][std::size_t(major)];
    const SweepAxis axis = sweepAxis(major);
    if (!index)
        index.emplace(layout.origins, linear ? marginsBelow(layout, map, periodic, axis) : std::vector<Index3>(), axis);
    return *index;
}

}  // namespace raysweep
