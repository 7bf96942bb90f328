/// Convergence (paper, section 2.2; docs/illumination.md, eq. L8): how much the estimate of radiosity changes from one
/// look to the next.
///
///     rms = sqrt( sum (S_n - S_(n-m))^2 / sum S_n^2 )    over voxels and wavelengths, m sweeps apart   (L8)
///
/// The paper looks every delta i = 20 sweeps and stops at a tolerance delta. Here a large volume is looked at in a
/// sample of its bricks.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Moves the recent deposits to the total ones.
void accumulateDeposits(SolverState& state);

constexpr std::size_t kMostSampled = 4096;  ///< bricks, of two million voxels

/// The same, in a sample of `kMostSampled` bricks if there are more.
/// @return the relative RMS change of their radiosity since theirs were last moved, which was `sweeps` sweeps ago
double accumulateAndMeasureChange(SolverState& state, int sweeps);

}  // namespace raysweep
