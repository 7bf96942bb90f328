/// Radiosity of solids, after the sweeps.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Light from one side falls on the outer voxels of a staircase and not on those behind them. So that it does not show,
/// what surface voxels received is averaged over their neighbours on the same surface, weighted by F: what all of them
/// took over what all of them could have taken. Light seen directly has no staircase, and keeps its shadows sharp.
/// @param received deposit over F of the surfaces' bricks, any unit  @param furnace F, any unit
/// @return the averages of `received`
BrickField evenedOut(const SolverState& state, const BrickField& received, const BrickField& furnace);

/// The inside of solids, where light does not get, takes the radiosity of the surface around it, as deep as one can see
/// into it: a renderer that interpolates or looks through a soft edge would mix it with black.
/// @param radiosity kUnknown in voxels to be filled, and still where nothing can be seen
void fillSolids(const SolverState& state, BrickField& radiosity);

}  // namespace raysweep
