#include "raysweep/sweep/sweep.h"

#include "raysweep/core/denormals.h"
#include "raysweep/core/parallel.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace raysweep {
namespace {

constexpr double kSpent = 1e-6;  ///< rays in a periodic volume are followed until this part of their power is left
constexpr int kMostRepetitions = 100000;

/// A sweep from one end of the bricks' bounding box to the other.
SweepTotals sweepThrough(const SweepVolume& volume, const RayFront& front, Interpolation interpolation,
                         const ExchangeFields& fields, const ExchangeStep& step) {
    const RayTiles cut = cutIntoTiles(front, volume.layout, volume.index[std::size_t(front.axis.major)]);
    std::vector<TileSums> sums(cut.tiles.size());
    const auto exchangeTiles = [&](auto exchange, std::size_t begin, std::size_t end) {
        parallelFor(end - begin, [&](std::size_t i) {
            const FlushDenormals flush;  // rays deep in smoke fade into them: they would cost half the time
            exchange(front, cut.tiles[begin + i], fields, step, sums[begin + i]);
        });
    };
    if (interpolation == Interpolation::nearest)
        exchangeTiles(exchangeNearest, 0, cut.tiles.size());
    else
        for (std::size_t colour = 0; colour + 1 < cut.colours.size(); ++colour)
            exchangeTiles(exchangeLinear, cut.colours[colour], cut.colours[colour + 1]);

    // Rays that enter the bounding box but meet no brick were never made: they come out as they went in.
    SweepTotals totals;
    double made = 0;
    for (const TileSums& tile : sums) made += tile.rays;
    const double entered = countRaysThatEnter(front);
    for (int c = 0; c < fields.channels; ++c) {
        for (const TileSums& tile : sums) totals.escaped[c] += tile.escaped[c];
        totals.escaped[c] += (entered - made) * double(step.entering[c]);
        totals.entered[c] = entered * double(step.entering[c]);
    }
    return totals;
}

double powerOf(const CrossingRays& rays) {
    return std::accumulate(rays.power.begin(), rays.power.end(), 0.0,
                           [](double sum, float ray) { return sum + double(ray); });
}

/// A sweep where the volume repeats along the sweep's axis. All repetitions are equal, so the rays that leave one are
/// those that enter the next: they go round, with nothing new entering or shot, until hardly any power is left.
SweepTotals sweepAround(const SweepVolume& volume, RayFront front, Interpolation interpolation, ExchangeFields fields,
                        ExchangeStep step) {
    alignas(64) static const float kNothing[kBrickVoxels] = {0};
    // In the first round nobody knows what rays come out of the repetition before as: the second one measures.
    const BrickView<float> furnace = fields.furnace;
    BrickField unused;
    if (furnace.data) fields.furnace = viewOf(unused = BrickField(fields.surfaces->bricks.size()));
    CrossingRays arriving(front, fields.channels, furnace.data), leaving(front, fields.channels, furnace.data);
    fields.arriving = &arriving;
    fields.leaving = &leaving;
    SweepTotals totals = sweepThrough(volume, front, interpolation, fields, step);
    step.zeta = 0;
    for (int c = 0; c < fields.channels; ++c) {
        step.entering[c] = 0;
        fields.source[c] = {kNothing, 0};
    }
    const double first = powerOf(leaving);
    const auto goesOn = [&](int i) { return powerOf(leaving) > kSpent * first || (i == 0 && furnace.data); };
    for (int i = 0; i < kMostRepetitions && goesOn(i); ++i) {
        std::swap(arriving, leaving);
        leaving = CrossingRays(front, fields.channels, i == 0 && furnace.data);
        fields.furnace = i == 0 ? furnace : BrickView<float>();
        front = nextRepetition(front);
        const SweepTotals more = sweepThrough(volume, front, interpolation, fields, step);
        for (int c = 0; c < fields.channels; ++c) totals.escaped[c] += more.escaped[c];
    }
    const std::size_t perChannel = leaving.power.size() / std::size_t(fields.channels);
    for (std::size_t i = 0; i < leaving.power.size(); ++i) totals.escaped[i / perChannel] += double(leaving.power[i]);
    return totals;
}

}  // namespace

SweepTotals sweep(const SweepVolume& volume, const RayFront& front, Interpolation interpolation,
                  const ExchangeFields& fields, const ExchangeStep& step) {
    return front.periodic ? sweepAround(volume, front, interpolation, fields, step)
                          : sweepThrough(volume, front, interpolation, fields, step);
}

void settle(const SweepVolume& volume, const ExchangeFields& fields, const ExchangeStep& step) {
    parallelFor(
        volume.layout.brickCount(), [&](std::size_t b) { settleBrick(fields, step, b); }, 16);
}

}  // namespace raysweep
