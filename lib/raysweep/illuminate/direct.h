/// Light that has not been scattered yet: suns, point lights, quads and emission, turned into power to be shot, and
/// into what surfaces show of it (docs/illumination.md, eq. L6 and L7; the paper shows what was deposited instead):
///
///     q        = Σ g D + p / (1 - albedo (1 - p)) P                                              (L6)
///     q_s      = Σ g D + p albedo (1 - p) / (1 - albedo (1 - p)) P
///     S_direct = albedo E V max(0, -ω·n) / π,    V = D / F                                       (L7)
///
/// with D what the light of suns and points leaves behind on its straight way, P the power emitted in the voxel (of
/// surface voxels, and in the `paper` exchange, all is shot), g the effective albedo and p the escape probability
/// (sweep/escape.h); q_s, what a medium's radiosity shows of q, leaves out what is emitted and not scattered yet, which
/// shines by itself (emission.h); E the light's irradiance across its direction ω, n the surface's normal, and V its
/// visibility: F is what the same light would leave if nothing but the voxel's own surface came before it, so the
/// staircase that both have cancels.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Voxels that emit.
struct Emitters {
    std::size_t voxels = 0;
    double power = 0;  ///< W, of all wavelengths
};

/// Fills `state.power.source`, `perInjection` and `unit`: what one injection adds; and `seen` and `emitted`: what
/// of it shows on surfaces.
Emitters addDirectLight(SolverState& state, const Scene& scene);

}  // namespace raysweep
