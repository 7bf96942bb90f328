/// What a solution gives out: grids of radiosity and unshot power.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// The estimate so far. @param spread with what is unshot, spread
openvdb::GridBase::Ptr snapshotGrid(const SolverState& state, const Scene& scene, bool spread);

/// The answer. It takes the place of the deposits, so that the peak of memory stays in the sweeps.
openvdb::GridBase::Ptr finalGrid(SolverState& state, const Scene& scene);

/// Unshot power, W; without a sweep that is what the sources add. Takes the field from `state`.
openvdb::GridBase::Ptr unshotGrid(SolverState& state, const Scene& scene);

}  // namespace raysweep
