#include "raysweep/illuminate/power_balance.h"

#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/state.h"
#include "raysweep/illuminate/voxel_radiance.h"

#include <algorithm>
#include <cmath>

namespace raysweep {

ChannelPower& ChannelPower::operator+=(const ChannelPower& other) {
    for (int c = 0; c < kMaxChannels; ++c) value[c] += other.value[c];
    return *this;
}

double PowerBalance::error() const {
    double worst = 0;
    for (int c = 0; c < kMaxChannels; ++c)
        if (injected[c] > 0)
            worst = std::max(worst, std::abs(injected[c] - absorbed[c] - escaped[c] - unshot[c]) / injected[c]);
    return worst;
}

ChannelPower unshotPower(const SolverState& state) {
    ChannelPower power;
    for (int c = 0; c < state.medium.channels; ++c) power.value[c] = sumOf(state.power.unshot[c]);
    return power;
}

ChannelPower absorbedPower(const SolverState& state) {
    if (state.power.total[0].empty()) return {};
    return orderedSum<ChannelPower>(state.medium.volume.layout.brickCount(), [&](std::size_t b) {
        ChannelPower sum;
        double share[kBrickVoxels];
        for (int c = 0; c < state.medium.channels; ++c) {
            absorbedShares(state, c, b, share);
            const float* const total = state.power.total[c].brick(b);
            const float* const recent = state.power.recent[c].brick(b);
            for (int i = 0; i < kBrickVoxels; ++i) sum.value[c] += (double(total[i]) + double(recent[i])) * share[i];
        }
        return sum;
    });
}

PowerBalance powerBalance(const SolverState& state) {
    const PowerFields& power = state.power;
    const ChannelPower absorbed = absorbedPower(state), unshot = unshotPower(state);
    const double perInjection = power.unit / std::max(1, power.injections);
    PowerBalance result;
    for (int c = 0; c < state.medium.channels; ++c) {
        result.injected[c] = power.perInjection.injected[c] * power.unit + power.swept.injected[c] * perInjection;
        result.escaped[c] = power.perInjection.escaped[c] * power.unit + power.swept.escaped[c] * perInjection;
        result.absorbed[c] = power.perInjection.absorbed[c] * power.unit + absorbed.value[c] * perInjection;
        // Without a sweep the sources are what is still unshot.
        const bool still = power.injections == 0 && power.hasSource();
        result.unshot[c] = still ? power.unit * sumOf(power.source[c]) : unshot.value[c] * perInjection;
    }
    return result;
}

}  // namespace raysweep
