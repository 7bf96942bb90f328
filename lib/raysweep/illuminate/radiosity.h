/// From deposits to radiosity.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Radiosity of channel `channel`, W m^-2 sr^-1. kUnknown in voxels that have none of their own: those without
/// extinction; and those inside opaque solids, which light does not reach and which show through the surface only by
/// interpolation.
/// @param extra further deposit, in the state's unit of power; may be empty
/// @param radiosity receives the result; may be one of the state's own fields
void computeRadiosity(const SolverState& state, int channel, const BrickField& extra, BrickField& radiosity);

constexpr float kUnknown = -1;

/// Deposit of all unshot power of a wavelength, spread in proportion to density times the magnitude of its gradient,
/// or, where there is no gradient anywhere, to density (paper, section 2.2). In the state's unit of power. Empty if
/// nothing has a density.
BrickField spreadUnshot(const SolverState& state, int channel);

}  // namespace raysweep
