#include "raysweep/bricks/gradient.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/radiosity.h"

#include <utility>

namespace raysweep {
namespace {

/// Scales the field so that it sums to `total`. @return false if it is 0 everywhere
bool scaleTo(BrickField& field, double total) {
    const double sum = sumOf(field);
    if (!(sum > 0)) return false;
    parallelFor(field.brickCount(), [&](std::size_t b) {
        for (int i = 0; i < kBrickVoxels; ++i) field.brick(b)[i] = float(double(field.brick(b)[i]) / sum * total);
    });
    return true;
}

}  // namespace

BrickField spreadUnshot(const SolverState& state, int channel) {
    const BrickLayout& layout = state.medium.volume.layout;
    const Matrix3 indexFromWorld = layout.worldFromIndex.inverse();
    BrickField weights(layout.brickCount());
    const auto fill = [&](bool withGradient) {
        parallelFor(layout.brickCount(), [&](std::size_t b) {
            const PaddedBrick<float> tau(layout, state.medium.volume.map, state.medium.volume.periodic, b,
                                         [&](std::size_t n) { return state.medium.tau.brick(n); });
            for (int i = 0; i < kBrickVoxels; ++i) {
                const int x = i >> 6, y = (i >> 3) & 7, z = i & 7;
                if (tau.at(x, y, z) == 0) continue;
                const double gradient =
                    withGradient ? worldGradient(gradientAt(tau, x, y, z), indexFromWorld).length() : 1;
                weights.brick(b)[i] = float(double(tau.at(x, y, z)) * gradient);
            }
        });
    };
    const double unshot = unshotPower(state).value[channel];
    fill(true);
    if (scaleTo(weights, unshot)) return weights;
    fill(false);
    return scaleTo(weights, unshot) ? std::move(weights) : BrickField();
}

}  // namespace raysweep
