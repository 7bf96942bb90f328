/// Light that has not been scattered yet: suns, point lights and emission, turned into power to be shot.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Fills `state.source`, `state.perInjection` and `state.powerUnit`: what one injection adds.
/// @return voxels that emit but have no extinction
std::size_t addDirectLight(SolverState& state, const Scene& scene);

}  // namespace raysweep
