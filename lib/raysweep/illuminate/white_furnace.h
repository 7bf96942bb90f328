/// The white furnace of solids that are partly soft or noisy: the same scene in a sky of radiance 1 with albedo 1 and
/// no other light, swept along with the true one by the same rays. What a voxel collides there is its F.
///
/// The local furnace (exchange.h) is good where surfaces are opaque and smooth. Where light goes through them, or
/// normals are noise, it lacks what is scattered again, and S = albedo D / F would be more than energy allows. Here
/// nothing is lacking: with albedo 1 and only a sky, D is F to the bit, and with less, voxel by voxel and sweep by
/// sweep, no more, for all that is done to it grows with what comes in.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Makes room for it, if the solids of `state` need one.
void allocateWhiteFurnace(SolverState& state, Interpolation interpolation);

/// A sweep of the furnace by the rays of `beams`. @param injecting with a sky
void sweepWhiteFurnace(SolverState& state, std::vector<Beam> beams, Interpolation interpolation,
                       const ExchangeConstants& constants, bool injecting);

/// Unshot power of the furnace as part of what came in; 0 without a furnace.
double unshotShareOfFurnace(const SolverState& state);

}  // namespace raysweep
