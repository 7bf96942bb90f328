/// Fields of the solver as grids for users.
#pragma once

#include "raysweep/bricks/brick_grids.h"

#include <vector>

namespace raysweep {

/// A grid of the fields' values, FloatGrid for one field, Vec3SGrid for three, with the voxels of `topology` active
/// (tiles as voxels), background 0 and the transform of `topology`.
openvdb::GridBase::Ptr gridFromFields(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                      const std::vector<BrickField>& fields);

/// The same with those voxels active, wherever they are, in which one of the fields is not 0.
/// @param fields so many, `count`, one after the other; FloatGrid for one, Vec3SGrid for three
openvdb::GridBase::Ptr sparseGridFromFields(const BrickLayout& layout, const openvdb::math::Transform& transform,
                                            const BrickField* fields, int count);

/// As gridFromFields for radiosity, made ready for interpolation: voxels of unknown (negative) value and all voxels
/// within one voxel of an active one take the mean of those of their 26 neighbours that have a value. Without this, a
/// renderer that interpolates would darken every border towards the background (docs/illumination.md).
openvdb::GridBase::Ptr extendedGridFromFields(const BrickLayout& layout, const openvdb::FloatGrid& topology,
                                              const std::vector<BrickField>& fields);

}  // namespace raysweep
