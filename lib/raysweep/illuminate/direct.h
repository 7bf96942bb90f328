/// Light that has not been scattered yet: suns, point lights, quads and emission, turned into power to be shot.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Voxels that emit.
struct Emitters {
    std::size_t voxels = 0;
    std::size_t invisible = 0;  ///< those of the emission grid that have no extinction
};

/// Fills `state.power.source`, `perInjection` and `unit`: what one injection adds; and `seen` and `emitted`: what
/// of it shows on surfaces.
Emitters addDirectLight(SolverState& state, const Scene& scene);

}  // namespace raysweep
