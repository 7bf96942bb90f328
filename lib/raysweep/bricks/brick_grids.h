/// From grids to bricks.
#pragma once

#include "raysweep/bricks/bricks.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// Bricks that cover every active voxel and active tile of `grids`, which must share one linear transform.
/// @param bytesPerVoxel what the caller will allocate per voxel of a brick
/// @throw InvalidArgument for a transform that is not linear or is singular, grids whose transforms differ,
///        active voxels more than 2^24 voxels apart, and for a layout that would need more memory than the machine has.
BrickLayout layoutBricks(const std::vector<openvdb::GridBase::ConstPtr>& grids, std::size_t bytesPerVoxel);

/// Copies `grid` times `scale` to a field; inactive voxels become 0.
BrickField gatherField(const BrickLayout& layout, const openvdb::FloatGrid& grid, double scale);

/// As above for component `channel` (0..2) of a float or vec3s grid (a float grid has the same value in all).
/// @throw InvalidArgument for grids of other types
BrickField gatherChannel(const BrickLayout& layout, const openvdb::GridBase& grid, int channel, double scale);

/// Bits of a brick's voxels, in offset order.
using BrickMask = openvdb::util::NodeMask<3>;

/// The active voxels of `topology` in brick `b`; tiles count as their voxels.
BrickMask activeMask(const BrickLayout& layout, const openvdb::FloatGrid& topology, std::size_t b);

}  // namespace raysweep
