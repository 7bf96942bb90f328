#include "raysweep/illuminate/convergence.h"

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/voxel_radiance.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

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
void accumulateVoxel(float& total, float& recent) {
    float sum = total + recent;
    if (sum - total > recent) sum = std::nextafter(sum, 0.0f);
    recent = std::max(0.0f, recent - (sum - total));
    total = sum;
}

Squares accumulateBrick(SolverState& state, std::size_t b, int before) {
    const double now = 1.0 / state.power.injections, then = before > 0 ? 1.0 / before : 0;
    Squares sum;
    for (int c = 0; c < state.medium.channels; ++c) {
        const BrickRadiance radiance(state, c, b);
        float* const total = state.power.total[c].brick(b);
        float* const recent = state.power.recent[c].brick(b);
        for (int i = 0; i < kBrickVoxels; ++i) {
            if (radiance.isKnown(i)) {
                const double deposit = double(total[i]) + double(recent[i]);
                const double perPower = radiance.perPower(i);
                const double value = radiance.directly(i, perPower) + radiance.scattered(i, deposit * now * perPower);
                const double change = radiance.scattered(i, (deposit * now - double(total[i]) * then) * perPower);
                sum.value += value * value;
                sum.difference += change * change;
            }
            accumulateVoxel(total[i], recent[i]);
        }
    }
    return sum;
}

}  // namespace

void accumulateDeposits(SolverState& state) {
    parallelFor(
        state.medium.volume.layout.brickCount(),
        [&](std::size_t b) {
            for (int c = 0; c < state.medium.channels; ++c)
                for (int i = 0; i < kBrickVoxels; ++i)
                    accumulateVoxel(state.power.total[c].brick(b)[i], state.power.recent[c].brick(b)[i]);
        },
        16);
}

double accumulateAndMeasureChange(SolverState& state, int sweeps) {
    const Squares sum = orderedSum<Squares>(
        state.medium.volume.layout.brickCount(),
        [&](std::size_t b) { return accumulateBrick(state, b, state.power.injections - sweeps); }, 16);
    return sum.value > 0 ? std::sqrt(sum.difference / sum.value) : 0;
}

}  // namespace raysweep
