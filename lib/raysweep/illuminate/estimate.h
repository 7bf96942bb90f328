/// From deposits to the answer: radiosity, its convergence, and whether the power adds up.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Moves the recent deposits to the total ones.
void foldDeposits(SolverState& state);

/// The same. @return relative RMS difference of radiosity to the estimate at the last fold, which was `sweeps` sweeps
/// ago.
double foldDeposits(SolverState& state, int sweeps);

/// Unshot power of each wavelength, in powerUnit.
ChannelPower unshotPower(const SolverState& state);

/// The books after all sweeps, per injection, W.
PowerBalance balance(const SolverState& state);

/// F / (4 pi) of the voxels of brick `b`, world unit^2, taken all to be medium.
void absorbingAreas(const SolverState& state, std::size_t b, float* area);

/// Radiosity of channel `channel`, W m^-2 sr^-1. kUnknown in voxels that have none of their own: those without
/// extinction; and those inside opaque solids, which light does not reach and which show through the surface only by
/// interpolation.
/// @param extra further deposit, in powerUnit; may be empty
/// @param radiosity receives the result; may be one of the state's own fields
void computeRadiosity(const SolverState& state, int channel, const BrickField& extra, BrickField& radiosity);

constexpr float kUnknown = -1;

/// Deposit of all unshot power of a wavelength, spread in proportion to density times the magnitude of its gradient,
/// or, where there is no gradient anywhere, to density (paper, section 2.2). In powerUnit. Empty if nothing
/// has a density.
BrickField spreadUnshot(const SolverState& state, int channel);

}  // namespace raysweep
