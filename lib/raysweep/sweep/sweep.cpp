#include "raysweep/sweep/sweep.h"

#include "raysweep/core/denormals.h"
#include "raysweep/core/parallel.h"

namespace raysweep {

SweepTotals sweep(const SweepVolume& volume, const RayFront& front, Interpolation interpolation,
                  const ExchangeFields& fields, const ExchangeStep& step) {
    const RayTiles cut = cutIntoTiles(front, volume.layout, volume.index[std::size_t(front.axis.major)]);
    std::vector<TileSums> sums(cut.tiles.size());
    const auto exchange = interpolation == Interpolation::nearest ? exchangeNearest : exchangeLinear;
    for (std::size_t colour = 0; colour + 1 < cut.colours.size(); ++colour) {
        const std::size_t first = cut.colours[colour];
        parallelFor(cut.colours[colour + 1] - first, [&](std::size_t i) {
            const FlushDenormals flush;  // rays deep in smoke fade into them: they would cost half the time
            exchange(front, cut.tiles[first + i], fields, step, sums[first + i]);
        });
    }

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

void settle(const SweepVolume& volume, const ExchangeFields& fields, const ExchangeStep& step) {
    parallelFor(
        volume.layout.brickCount(), [&](std::size_t b) { settleBrick(fields, step, b); }, 16);
}

}  // namespace raysweep
