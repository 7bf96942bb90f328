#include "raysweep/illuminate/radiosity.h"

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/surface_radiosity.h"
#include "raysweep/illuminate/voxel_radiance.h"

#include <algorithm>

namespace raysweep {
namespace {

/// Deposit over F in the surfaces' bricks.
template <class DepositOf>
BrickField receivedBySurfaces(const SolverState& state, int channel, const DepositOf& depositOf) {
    BrickField received(state.solid.surfaces.bricks.size());
    parallelFor(state.medium.volume.layout.brickCount(), [&](std::size_t b) {
        if (!state.solid.surfaces.normals(b)) return;
        const BrickRadiance radiance(state, channel, b);
        float* const to = received.brick(state.solid.surfaces.slots[b]);
        for (int i = 0; i < kBrickVoxels; ++i)
            if (radiance.isSurface(i) && radiance.isKnown(i)) to[i] = float(depositOf(b, i) * radiance.perPower(i));
    });
    return received;
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
    const BrickField even =
        state.solid.furnace.empty() ? BrickField() : evenedOut(state, receivedBySurfaces(state, channel, depositOf));
    const double unit = state.radianceUnit();
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
                S = float((radiance.scattered(i, received) + radiance.directly(i, perPower)) * unit);
            }
        },
        16);
    fillSolids(state, radiosity);
}

}  // namespace raysweep
