/// What fills space: extinction, albedo and emission.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// A participating medium. Grids of albedo and emission have any linear transform.
struct Medium {
    openvdb::FloatGrid::ConstPtr density;    ///< any non-negative scalar, fog; 0 outside its active voxels
    double extinctionScale = 1;              ///< extinction per unit density, 1/world unit
    Color albedo = grey(0.9f);               ///< single-scattering albedo, in [0,1]; used where no grid is given
    openvdb::GridBase::ConstPtr albedoGrid;  ///< FloatGrid or Vec3SGrid, in [0,1], 0 where inactive; may be null
    openvdb::GridBase::ConstPtr emission;    ///< FloatGrid or Vec3SGrid, emitted power density, W/world unit^3,
                                             ///< isotropic, 0 where inactive, with smoke or without; or null
    double emissionScale = 1;                ///< factor on `emission`
    bool solid = false;  ///< a classified solid, which has surfaces (a ramp, a table, a level set), not a fog
};

/// What light meets, as a grid "extinction", 1/world unit; tiles as voxels.
openvdb::FloatGrid::Ptr extinctionGrid(const Medium& medium);

}  // namespace raysweep
