#include "raysweep/illuminate/state.h"

#include "raysweep/core/parallel.h"
#include "raysweep/volume/brick_grids.h"
#include "raysweep/volume/voxel_check.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

// A voxel this thick is a wall; more would only overflow.
constexpr float kThickest = 1e9f;

BrickField uniformBrick(float value) {
    BrickField field(1);
    std::fill_n(field.brick(0), kBrickVoxels, value);
    return field;
}

/// Bytes per voxel of a brick at the peak: tau, fields per wavelength, albedo.
std::size_t bytesPerVoxel(const Scene& scene, const Plan& plan) {
    const std::size_t perChannel = 4 + (scene.medium.albedoGrid ? 1 : 0);
    return 4 * (1 + std::size_t(plan.channels) * perChannel);
}

}  // namespace

SolverState prepareState(const Scene& scene, const IlluminateOptions& options, const Plan& plan) {
    const Medium& medium = scene.medium;
    checkVoxels(*medium.density, "density");
    std::vector<openvdb::GridBase::ConstPtr> grids{medium.density};
    if (medium.emission) grids.push_back(medium.emission);
    SolverState state(layoutBricks(grids, bytesPerVoxel(scene, plan)));
    state.volume.periodic = options.periodic;
    state.exchange = options.exchange;
    state.channels = plan.channels;

    const BrickLayout& bricks = state.volume.layout;
    state.tau = gatherField(bricks, *medium.density, medium.extinctionScale * state.escape.meanStepLength());
    parallelFor(
        bricks.brickCount(),
        [&](std::size_t b) {
            float* const tau = state.tau.brick(b);
            for (int i = 0; i < kBrickVoxels; ++i) tau[i] = std::min(tau[i], kThickest);
        },
        16);

    state.zero = uniformBrick(0);
    state.uniformAlbedo = !medium.albedoGrid;
    if (medium.albedoGrid) checkAlbedo(*medium.albedoGrid);
    for (int c = 0; c < state.channels; ++c)
        state.albedo[c] =
            medium.albedoGrid ? gatherChannel(bricks, *medium.albedoGrid, c, 1) : uniformBrick(medium.albedo[c]);
    return state;
}

void allocateSweepFields(SolverState& state, const IlluminateOptions& options) {
    const std::size_t bricks = state.volume.layout.brickCount();
    for (int c = 0; c < state.channels; ++c) {
        state.unshot[c] = BrickField(bricks);
        state.recent[c] = BrickField(bricks);
        state.total[c] = BrickField(bricks);
        if (options.interpolation == Interpolation::linear) state.fresh[c] = BrickField(bricks);
    }
}

ExchangeStep exchangeStep(const SolverState& state, const RayFront& front, double zeta) {
    ExchangeStep step;
    step.model = state.exchange;
    step.escape = state.escape.fit();
    const double length =
        state.exchange == MediumExchange::paper ? std::cbrt(state.volume.layout.voxelVolume) : front.stepLength;
    step.stepScale = float(length / state.escape.meanStepLength());
    step.zeta = float(zeta);
    return step;
}

double thickShare(const SolverState& state) {
    const double limit = 2 * state.escape.meanStepLength() / std::cbrt(state.volume.layout.voxelVolume);
    const double thick = orderedSum(state.volume.layout.brickCount(), [&](std::size_t b) {
        return double(std::count_if(state.tau.brick(b), state.tau.brick(b) + kBrickVoxels,
                                    [&](float tau) { return double(tau) > limit; }));
    });
    return thick / std::max<double>(1, double(state.volume.layout.activeVoxels));
}

}  // namespace raysweep
