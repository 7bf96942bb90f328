#include "raysweep/sweep/sweep.h"

#include "raysweep/core/denormals.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/sweep/wavefront.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace raysweep {
namespace {

constexpr double kSpent = 1e-6;  ///< rays in a periodic volume are followed until this part of their power is left
constexpr int kMostRepetitions = 100000;

/// Rays that go from one repetition of a periodic volume to the next.
struct Crossing {
    CrossingRays* arriving = nullptr;
    CrossingRays* leaving = nullptr;
};

/// All of a sweep but its rays.
struct Swept {
    const SweepVolume& volume;
    Interpolation interpolation;
    const ExchangeFields& fields;
    const ExchangeConstants& constants;
};

/// A sweep from one end of the bricks' bounding box to the other.
std::vector<RaySums> sweepThrough(const Swept& what, const std::vector<Beam>& beams, const Crossing& crossing = {}) {
    const ExchangeFields& fields = what.fields;
    const bool linear = what.interpolation == Interpolation::linear;
    const RayFront& front = beams.front().front;
    const BrickIndex& index = what.volume.indexFor(front.axis.major, what.interpolation);
    std::vector<FrontRays> rays(beams.size());
    parallelFor(beams.size(), [&](std::size_t i) {
        rays[i] = FrontRays(beams[i], index, linear ? kBrickEdge : 0, fields.channels, fields.furnace.data != nullptr);
        rays[i].enter(beams[i], crossing.arriving);
    });

    const Wavefront wavefront(what.volume, front, index, linear);
    const SweptBeams swept(beams, rays);
    parallelWavefront(wavefront.slabs(), wavefront.strips(), [&](int slab, int strip) {
        const FlushDenormals flush;  // rays deep in smoke fade into them: they would cost half the time
        const std::vector<BrickVisit> visits = wavefront.visits(slab, strip);
        linear ? exchangeLinear(swept, visits, fields, what.constants)
               : exchangeNearest(swept, visits, fields, what.constants);
    });

    std::vector<RaySums> sums(beams.size());
    parallelFor(beams.size(), [&](std::size_t i) { sums[i] = rays[i].leave(beams[i], crossing.leaving); });
    return sums;
}

double powerOf(const CrossingRays& rays) {
    return std::accumulate(rays.power.begin(), rays.power.end(), 0.0,
                           [](double sum, float ray) { return sum + double(ray); });
}

/// A sweep where the volume repeats along the sweep's axis. All repetitions are equal, so the rays that leave one are
/// those that enter the next: they go round, with nothing new entering or shot, until hardly any power is left.
RaySums sweepAround(const SweepVolume& volume, Beam beam, Interpolation interpolation, ExchangeFields fields,
                    ExchangeConstants constants) {
    alignas(64) static const float kNothing[kBrickVoxels] = {0};
    // In the first round nobody knows what rays come out of the repetition before as: the second one measures.
    const BrickView<float> furnace = fields.furnace;
    BrickField unused;
    if (furnace.data) fields.furnace = viewOf(unused = BrickField(fields.surfaces->bricks.size()));
    CrossingRays arriving(beam.front, fields.channels, furnace.data),
        leaving(beam.front, fields.channels, furnace.data);
    const auto once = [&] {
        return sweepThrough({volume, interpolation, fields, constants}, {beam}, {&arriving, &leaving})[0];
    };
    RaySums totals = once();
    constants.zeta = 0;
    for (int c = 0; c < fields.channels; ++c) {
        beam.entering[c] = 0;
        fields.source[c] = {kNothing, 0};
    }
    const double first = powerOf(leaving);
    const auto goesOn = [&](int i) { return powerOf(leaving) > kSpent * first || (i == 0 && furnace.data); };
    for (int i = 0; i < kMostRepetitions && goesOn(i); ++i) {
        std::swap(arriving, leaving);
        leaving = CrossingRays(beam.front, fields.channels, i == 0 && furnace.data);
        fields.furnace = i == 0 ? furnace : BrickView<float>();
        beam.front = nextRepetition(beam.front);
        const RaySums more = once();
        for (int c = 0; c < fields.channels; ++c) totals.escaped[c] += more.escaped[c];
    }
    const std::size_t perChannel = leaving.power.size() / std::size_t(fields.channels);
    for (std::size_t i = 0; i < leaving.power.size(); ++i) totals.escaped[i / perChannel] += double(leaving.power[i]);
    return totals;
}

}  // namespace

std::vector<RaySums> sweep(const SweepVolume& volume, const std::vector<Beam>& beams, Interpolation interpolation,
                           const ExchangeFields& fields, const ExchangeConstants& constants) {
    const RayFront& first = beams.at(0).front;
    for (const Beam& beam : beams)
        if (beam.front.directionClass != first.directionClass)
            throw InvalidArgument("the beams of a sweep must go the same way along its axis and its rows");
    if (beams.size() > kMostBeams || (beams.size() > 1 && isPeriodic(volume.periodic)))
        throw InvalidArgument("a sweep takes at most " + std::to_string(kMostBeams) +
                              " beams, and one in a periodic volume");
    if (first.periodic) return {sweepAround(volume, beams[0], interpolation, fields, constants)};
    return sweepThrough({volume, interpolation, fields, constants}, beams);
}

void settle(const SweepVolume& volume, const std::vector<Beam>& beams, const ExchangeFields& fields,
            const ExchangeConstants& constants) {
    parallelFor(
        volume.layout.brickCount(), [&](std::size_t b) { settleBrick(beams, fields, constants, b); }, 16);
}

}  // namespace raysweep
