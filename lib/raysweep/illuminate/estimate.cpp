#include "raysweep/illuminate/estimate.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// F / (4 pi): mean over directions of the power that a voxel takes from rays of radiance 1, per steradian. World area.
double meanAbsorbingArea(const SolverState& state, double tau, double escapeProbability) {
    const double volume = state.volume.layout.voxelVolume, meanLength = state.escape.meanStepLength();
    if (state.exchange == MediumExchange::paper) {
        // A fixed opacity times the mean cross-section of a ray.
        const double opacity = -std::expm1(-tau * std::cbrt(volume) / meanLength);
        return opacity * volume / meanLength * state.escape.meanInverseLength();
    }
    return tau / meanLength * volume * escapeProbability;
}

/// Sums over a brick for the relative RMS difference.
struct Squares {
    double difference = 0, value = 0;
    Squares& operator+=(const Squares& other) {
        difference += other.difference;
        value += other.value;
        return *this;
    }
};

/// total += recent, and what rounding took from the sum stays in recent: a million sweeps lose nothing. Rounded down,
/// so that recent stays >= 0.
void foldVoxel(float& total, float& recent) {
    float sum = total + recent;
    if (sum - total > recent) sum = std::nextafter(sum, 0.0f);
    recent = std::max(0.0f, recent - (sum - total));
    total = sum;
}

Squares foldBrick(SolverState& state, std::size_t b, int before) {
    const EscapeFit& fit = state.escape.fit();
    alignas(64) float g[kBrickVoxels];
    const float* const tau = state.tau.brick(b);
    const double now = 1.0 / state.injections, then = before > 0 ? 1.0 / before : 0;
    Squares sum;
    for (int c = 0; c < state.channels; ++c) {
        effectiveAlbedos(state, c, b, g);
        const float* const source = state.hasSource() ? state.source[c].brick(b) : state.zero.brick(0);
        float* const total = state.total[c].brick(b);
        float* const recent = state.recent[c].brick(b);
        for (int i = 0; i < kBrickVoxels; ++i) {
            if (tau[i] > 0) {
                const double p = fit.probability(double(tau[i]));
                const double perArea = 1 / meanAbsorbingArea(state, double(tau[i]), p);
                const double deposit = double(total[i]) + double(recent[i]);
                const double value = (double(source[i]) + double(g[i]) * deposit * now) * perArea;
                const double change = double(g[i]) * (deposit * now - double(total[i]) * then) * perArea;
                sum.value += value * value;
                sum.difference += change * change;
            }
            foldVoxel(total[i], recent[i]);
        }
    }
    return sum;
}

}  // namespace

double foldDeposits(SolverState& state, int sweeps) {
    const Squares sum = orderedSum<Squares>(
        state.volume.layout.brickCount(), [&](std::size_t b) { return foldBrick(state, b, state.injections - sweeps); },
        16);
    return sum.value > 0 ? std::sqrt(sum.difference / sum.value) : 0;
}

ChannelPower unshotPower(const SolverState& state) {
    ChannelPower power;
    for (int c = 0; c < state.channels; ++c) power.value[c] = sumOf(state.unshot[c]);
    return power;
}

PowerBalance balance(const SolverState& state) {
    const bool swept = state.injections > 0;
    // What sweeps deposited, less what of it is scattered on, is absorbed.
    const ChannelPower absorbed =
        orderedSum<ChannelPower>(swept ? state.volume.layout.brickCount() : 0, [&](std::size_t b) {
            ChannelPower sum;
            alignas(64) float g[kBrickVoxels];
            for (int c = 0; c < state.channels; ++c) {
                effectiveAlbedos(state, c, b, g);
                for (int i = 0; i < kBrickVoxels; ++i)
                    sum.value[c] +=
                        (double(state.total[c].brick(b)[i]) + double(state.recent[c].brick(b)[i])) * (1 - double(g[i]));
            }
            return sum;
        });
    // Without a sweep the source is what is still unshot.
    const ChannelPower unshot = unshotPower(state);
    const double perInjection = state.powerUnit / std::max(1, state.injections);
    PowerBalance result;
    for (int c = 0; c < state.channels; ++c) {
        double left = unshot.value[c] * perInjection;
        if (!swept && state.hasSource()) left = state.powerUnit * sumOf(state.source[c]);
        result.injected[c] = state.perInjection.injected[c] * state.powerUnit + state.swept.injected[c] * perInjection;
        result.escaped[c] = state.perInjection.escaped[c] * state.powerUnit + state.swept.escaped[c] * perInjection;
        result.absorbed[c] = state.perInjection.absorbed[c] * state.powerUnit + absorbed.value[c] * perInjection;
        result.unshot[c] = left;
    }
    return result;
}

double PowerBalance::error() const {
    double worst = 0;
    for (int c = 0; c < kMaxChannels; ++c)
        if (injected[c] > 0)
            worst = std::max(worst, std::abs(injected[c] - absorbed[c] - escaped[c] - unshot[c]) / injected[c]);
    return worst;
}

void computeRadiosity(const SolverState& state, int channel, const BrickField& extra, BrickField& radiosity) {
    const std::size_t bricks = state.volume.layout.brickCount();
    const double perInjection = 1.0 / std::max(1, state.injections);
    const bool swept = !state.total[channel].empty();
    parallelFor(
        bricks,
        [&](std::size_t b) {
            alignas(64) float g[kBrickVoxels];
            const float* const tau = state.tau.brick(b);
            effectiveAlbedos(state, channel, b, g);
            for (int i = 0; i < kBrickVoxels; ++i) {
                if (!(tau[i] > 0)) {
                    radiosity.brick(b)[i] = 0;
                    continue;
                }
                double deposit =
                    swept ? double(state.total[channel].brick(b)[i]) + double(state.recent[channel].brick(b)[i]) : 0;
                if (!extra.empty()) deposit += double(extra.brick(b)[i]);
                const double source = state.hasSource() ? double(state.source[channel].brick(b)[i]) : 0;
                const double area = meanAbsorbingArea(state, double(tau[i]), state.escape.probability(double(tau[i])));
                radiosity.brick(b)[i] =
                    float((source + double(g[i]) * deposit * perInjection) * state.powerUnit / (4 * kPi * area));
            }
        },
        16);
}

}  // namespace raysweep
