/// Volumes from photographs as grids, and grids as bricks.
#pragma once

#include "raysweep/reconstruct/photo_level.h"
#include "raysweep/reconstruct/photo_result.h"

#include <functional>
#include <optional>
#include <vector>

namespace raysweep {

/// What is at an index of a layout: extinction, 1 / edge of a voxel, and colour; nothing beside the matter.
using VoxelAt = std::function<std::optional<CompositeVoxel>(std::size_t voxel)>;

/// Sets density, opacity and colour.
void addGrids(const CompositeLayout& layout, const ReconstructionGrid& grid, const VoxelAt& voxelAt,
              PhotoReconstruction& result);

/// Sets the coefficients of colours that depend on the direction. After addGrids.
/// @param constants the part of each voxel's colour that does not
void addDirectional(const PhotoLevel& level, const std::vector<CompositeVoxel>& constants, PhotoReconstruction& result);

/// The active voxels of a grid without tiles, one brick a leaf. @param origin of index (0,0,0) of the bricks, multiples
/// of 8
std::vector<MaskedBrick> bricksOf(const openvdb::FloatGrid& grid, const openvdb::Coord& origin);

}  // namespace raysweep
