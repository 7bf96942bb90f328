#include "raysweep/illuminate/convergence.h"

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/voxel_radiance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

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
/// so that recent stays >= 0; the float below a positive one has the bits below, which needs no call.
void accumulateVoxel(float& total, float& recent) {
    float sum = total + recent;
    std::uint32_t bits;
    std::memcpy(&bits, &sum, sizeof bits);
    bits -= sum - total > recent ? 1 : 0;
    std::memcpy(&sum, &bits, sizeof bits);
    recent = std::max(0.0f, recent - (sum - total));
    total = sum;
}

void accumulateBrick(SolverState& state, int channel, std::size_t b) {
    float* const total = state.power.total[channel].brick(b);
    float* const recent = state.power.recent[channel].brick(b);
    for (int i = 0; i < kBrickVoxels; ++i) accumulateVoxel(total[i], recent[i]);
}

/// Of many bricks one from each of `sampled` stretches of equal length, at a place that follows no pattern.
std::size_t sampledBrick(std::size_t i, std::size_t sampled, std::size_t bricks) {
    const std::size_t begin = i * bricks / sampled, end = (i + 1) * bricks / sampled;
    return begin + std::size_t((i * 0x9e3779b97f4a7c15ull) >> 32) % (end - begin);
}

Squares changeOfBrick(const SolverState& state, std::size_t b, int before) {
    const double now = 1.0 / state.power.injections, then = before > 0 ? 1.0 / before : 0;
    Squares sum;
    for (int c = 0; c < state.medium.channels; ++c) {
        const BrickRadiance radiance(state, c, b);
        const float* const total = state.power.total[c].brick(b);
        const float* const recent = state.power.recent[c].brick(b);
        for (int i = 0; i < kBrickVoxels; ++i) {
            if (!radiance.isKnown(i)) continue;
            const double deposit = double(total[i]) + double(recent[i]);
            const double perPower = radiance.perPower(i);
            const double value = radiance.directly(i, perPower) + radiance.scattered(i, deposit * now * perPower);
            const double change = radiance.scattered(i, (deposit * now - double(total[i]) * then) * perPower);
            sum.value += value * value;
            sum.difference += change * change;
        }
    }
    return sum;
}

}  // namespace

void accumulateDeposits(SolverState& state) {
    parallelFor(
        state.medium.volume.layout.brickCount(),
        [&](std::size_t b) {
            for (int c = 0; c < state.medium.channels; ++c) accumulateBrick(state, c, b);
        },
        16);
}

double accumulateAndMeasureChange(SolverState& state, int sweeps) {
    const std::size_t bricks = state.medium.volume.layout.brickCount(), sampled = std::min(bricks, kMostSampled);
    const Squares sum = orderedSum<Squares>(
        sampled,
        [&](std::size_t i) {
            const std::size_t b = sampledBrick(i, sampled, bricks);
            const Squares change = changeOfBrick(state, b, state.power.injections - sweeps);
            for (int c = 0; c < state.medium.channels; ++c) accumulateBrick(state, c, b);
            return change;
        },
        16);
    return sum.value > 0 ? std::sqrt(sum.difference / sum.value) : 0;
}

}  // namespace raysweep
