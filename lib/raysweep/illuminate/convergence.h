/// Convergence (paper, section 2.2; docs/illumination.md, eq. L8): how much the estimate of radiosity changes from one
/// look to the next.
///
///     rms = sqrt( sum (S_n - S_(n-m))^2 / sum S_n^2 )    over all voxels and wavelengths, m sweeps apart   (L8)
///
/// The paper looks every delta i = 20 sweeps and stops at a tolerance delta.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Moves the recent deposits to the total ones.
void accumulateDeposits(SolverState& state);

/// The same. @return the relative RMS change of radiosity since they were last moved, which was `sweeps` sweeps ago
double accumulateAndMeasureChange(SolverState& state, int sweeps);

}  // namespace raysweep
