/// What a fire gives off: on the solver's voxels for the sweeps, and on its own for the eye.
///
/// Its own light is no part of radiosity. As source radiance it would be q / (4 pi s), without bounds where there is
/// hardly any extinction s, and a renderer, which interpolates s and S apart, would multiply it by the s of a
/// neighbour. What is emitted per volume is known exactly, so it is shown as it is, with smoke or without
/// (docs/illumination.md, eq. L1); radiosity has what becomes of it, from the first scattering on.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Emission on the voxels of the density, with all its power; null without emission.
/// @throw InvalidArgument as checkVoxels and depositedOnto do
openvdb::GridBase::ConstPtr emissionOnVoxels(const Medium& medium);

/// Emission for a renderer: a grid "emission" on its own voxels, W/world unit^3, tiles as voxels, with a margin of one
/// voxel of 0 around them.
/// What surfaces of solids emit is left out: they shine to one side, and radiosity has it. Null without emission, and
/// if it is all of surfaces.
openvdb::GridBase::Ptr shownEmission(const SolverState& state, const Medium& medium);

/// Of power that a voxel without surface emits, what leaves it, and what of that has been scattered in it before and is
/// no longer the fire's own.
struct EmittedShares {
    double leaving, scattered;
};
EmittedShares emittedShares(const MediumFields& medium, double tau, double albedo);

}  // namespace raysweep
