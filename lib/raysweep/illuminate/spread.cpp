#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/estimate.h"
#include "raysweep/sweep/brick_map.h"

#include <cmath>
#include <utility>

namespace raysweep {
namespace {

double tauAt(const SolverState& state, const BrickMap& map, const Index3& voxel) {
    const std::uint32_t brick = map.find(voxel);
    return brick == kNoBrick ? 0 : double(state.tau.brick(brick)[offsetInBrick(voxel)]);
}

/// Magnitude of the world-space gradient by central differences.
double gradientMagnitude(const SolverState& state, const BrickMap& map, const Matrix3& indexFromWorld,
                         const Index3& voxel) {
    Vec3 inIndex;
    for (int axis = 0; axis < 3; ++axis) {
        Index3 step(0);
        step[axis] = 1;
        inIndex[axis] = 0.5 * (tauAt(state, map, voxel + step) - tauAt(state, map, voxel - step));
    }
    // d/dworld = indexFromWorld * d/dindex, in the row-vector convention.
    return (inIndex * indexFromWorld.transposed()).length();
}

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
    const BrickLayout& layout = state.volume.layout;
    const BrickMap map(layout);
    const Matrix3 indexFromWorld = layout.worldFromIndex.inverse();
    BrickField weights(layout.brickCount());
    const auto fill = [&](bool withGradient) {
        parallelFor(layout.brickCount(), [&](std::size_t b) {
            const float* const tau = state.tau.brick(b);
            for (int i = 0; i < kBrickVoxels; ++i) {
                if (tau[i] == 0) continue;
                const Index3 voxel = layout.origins[b] + Index3(i >> 6, (i >> 3) & 7, i & 7);
                const double gradient = withGradient ? gradientMagnitude(state, map, indexFromWorld, voxel) : 1;
                weights.brick(b)[i] = float(double(tau[i]) * gradient);
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
