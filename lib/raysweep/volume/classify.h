/// From scalar values to a solid: what a transfer function makes of a grid.
#pragma once

#include "raysweep/volume/grids.h"
#include "raysweep/volume/transfer_function.h"

namespace raysweep {

/// What a transfer function makes of a grid. Both grids have its transform, are sparse (pruned) and 0 where inactive.
struct ClassifiedVolume {
    openvdb::FloatGrid::Ptr extinction;  ///< called "extinction", 1/world unit; active where it is above 0
    openvdb::GridBase::Ptr albedo;       ///< called "albedo", with the same active voxels: FloatGrid if all its values
                                         ///< are grey, else Vec3SGrid; null if the function has no colour
};

/// Classifies the active voxels and tiles of `density`; inactive ones stay empty, whatever the function gives for their
/// value. The opacity is that of one voxel edge, the cube root of the voxel's volume.
/// @throw InvalidArgument for active values that are NaN or infinite (negative ones are fine), for a transform that is
/// not linear, and what `function.validate()` throws.
ClassifiedVolume classify(const openvdb::FloatGrid& density, const TransferFunction& function);

}  // namespace raysweep
