#include "raysweep/illuminate/white_furnace.h"

#include <algorithm>

namespace raysweep {
namespace {

/// Beyond this albedo light is scattered so often between the walls of a hollow that what the local furnace lacks along
/// their edges adds up.
constexpr float kBright = 0.9f;

bool isBright(const MediumFields& medium) {
    for (int c = 0; c < medium.channels; ++c) {
        const float* const values = medium.albedo[c].brick(0);
        const std::size_t count = medium.albedo[c].brickCount() * kBrickVoxels;
        if (std::any_of(values, values + count, [](float albedo) { return albedo > kBright; })) return true;
    }
    return false;
}

}  // namespace

void allocateWhiteFurnace(SolverState& state, Interpolation interpolation) {
    WhiteFurnace& furnace = state.solid.white;
    if (!state.solid.present || state.medium.model == ExchangeModel::asPrinted) return;
    if (!state.solid.surfaces.mixed && !isBright(state.medium)) return;
    const std::size_t bricks = state.medium.volume.layout.brickCount();
    furnace.albedo = BrickField(1);
    std::fill_n(furnace.albedo.brick(0), kBrickVoxels, 1.0f);
    furnace.unshot = BrickField(bricks);
    furnace.deposit = BrickField(bricks);
    if (interpolation == Interpolation::linear) furnace.fresh = BrickField(bricks);
}

void sweepWhiteFurnace(SolverState& state, std::vector<Beam> beams, Interpolation interpolation,
                       const ExchangeConstants& constants, bool injecting) {
    WhiteFurnace& furnace = state.solid.white;
    if (!furnace.present()) return;
    ExchangeFields fields;
    fields.tau = viewOf(state.medium.tau);
    fields.albedo[0] = sharedView(furnace.albedo);
    fields.source[0] = sharedView(state.power.zero);
    fields.unshot[0] = viewOf(furnace.unshot);
    fields.deposit[0] = viewOf(furnace.deposit);
    fields.fresh[0] = viewOf(furnace.fresh);
    fields.surfaces = &state.solid.surfaces;
    for (Beam& beam : beams) beam.entering[0] = injecting ? beam.furnaceRay : 0;
    const std::vector<RaySums> sums = sweep(state.medium.volume, beams, interpolation, fields, constants);
    if (interpolation == Interpolation::linear) settle(state.medium.volume, beams, fields, constants);
    for (const RaySums& sum : sums) furnace.injected += sum.entered[0];
}

double unshotShareOfFurnace(const SolverState& state) {
    const WhiteFurnace& furnace = state.solid.white;
    return furnace.injected > 0 ? sumOf(furnace.unshot) / furnace.injected : 0;
}

}  // namespace raysweep
