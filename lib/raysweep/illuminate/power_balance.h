/// Where the power went.
#pragma once

#include "raysweep/core/types.h"

namespace raysweep {

/// Power, W, per wavelength and per injection: injected = absorbed + escaped + unshot.
///
/// What entered and left is counted as rays do; what is absorbed and unshot is what the final fields hold, so that the
/// balance is a statement about the answer.
struct PowerBalance {
    double injected[kMaxChannels] = {0}, absorbed[kMaxChannels] = {0}, escaped[kMaxChannels] = {0},
           unshot[kMaxChannels] = {0};
    /// Largest |injected - absorbed - escaped - unshot| / injected of the wavelengths; 0 without light.
    double error() const;
};

/// One power for each wavelength.
struct ChannelPower {
    double value[kMaxChannels] = {0};
    ChannelPower& operator+=(const ChannelPower& other);
    double sum() const { return value[0] + value[1] + value[2]; }
};

struct SolverState;

/// Power that is still to be shot, in the state's unit.
ChannelPower unshotPower(const SolverState& state);

/// Power that sweeps have brought into voxels to stay, all injections together, in the state's unit.
ChannelPower absorbedPower(const SolverState& state);

/// The balance of `state` as it is, W.
PowerBalance powerBalance(const SolverState& state);

}  // namespace raysweep
