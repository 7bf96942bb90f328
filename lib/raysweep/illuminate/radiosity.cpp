#include "raysweep/illuminate/radiosity.h"

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/surface_radiosity.h"
#include "raysweep/illuminate/voxel_radiance.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// Deposit over F in the surfaces' bricks, averaged.
template <class DepositOf>
BrickField receivedBySurfaces(const SolverState& state, int channel, const DepositOf& depositOf) {
    BrickField received(state.solid.surfaces.bricks.size()), furnace(state.solid.surfaces.bricks.size());
    parallelFor(state.medium.volume.layout.brickCount(), [&](std::size_t b) {
        if (!state.solid.surfaces.normals(b)) return;
        const BrickRadiance radiance(state, channel, b);
        float* const to = received.brick(state.solid.surfaces.slots[b]);
        float* const F = furnace.brick(state.solid.surfaces.slots[b]);
        for (int i = 0; i < kBrickVoxels; ++i) {
            if (!radiance.isSurface(i) || !radiance.isKnown(i)) continue;
            to[i] = float(depositOf(b, i) * radiance.perPower(i));
            F[i] = float(1 / radiance.perPower(i));
        }
    });
    return evenedOut(state, received, furnace);
}

/// What no radiance within a solid can exceed, in `radianceUnit`: that of the sky, if there is no other light. F is
/// found to keep this; what is left above are single voxels of a medium by the noise of their directions, and edges of
/// sharp solids.
double brightestPossible(const SolverState& state, int channel) {
    const bool known = state.solid.present && !state.power.hasSource() && state.power.injections > 0 &&
                       state.medium.model == ExchangeModel::corrected;
    return known ? state.power.brightest[channel] : INFINITY;
}

}  // namespace

void computeRadiosity(const SolverState& state, int channel, const BrickField& extra, BrickField& radiosity) {
    const std::size_t bricks = state.medium.volume.layout.brickCount();
    const double perInjection = 1.0 / std::max(1, state.power.injections);
    const bool swept = !state.power.total[channel].empty();
    const auto depositOf = [&](std::size_t b, int i) {
        double deposit =
            swept ? double(state.power.total[channel].brick(b)[i]) + double(state.power.recent[channel].brick(b)[i])
                  : 0;
        if (!extra.empty()) deposit += double(extra.brick(b)[i]);
        return deposit * perInjection;
    };
    const BrickField even = state.solid.furnace.empty() ? BrickField() : receivedBySurfaces(state, channel, depositOf);
    const double unit = state.radianceUnit(), brightest = brightestPossible(state, channel);
    parallelFor(
        bricks,
        [&](std::size_t b) {
            const BrickRadiance radiance(state, channel, b);
            for (int i = 0; i < kBrickVoxels; ++i) {
                float& S = radiosity.brick(b)[i];
                if (!radiance.isKnown(i)) {
                    S = kUnknown;
                    continue;
                }
                const double perPower = radiance.perPower(i);
                const double received = radiance.isSurface(i) && !even.empty()
                                            ? double(even.brick(state.solid.surfaces.slots[b])[i])
                                            : depositOf(b, i) * perPower;
                const double found = radiance.scattered(i, received) + radiance.directly(i, perPower);
                const double albedo = double(state.medium.albedoView(channel).brick(b)[i]);
                S = float(std::min(found, albedo * brightest) * unit);
            }
        },
        16);
    fillSolids(state, radiosity);
}

}  // namespace raysweep
