/// Voxel values that light transport cannot work with, and what a file must keep so that other programs show it.
#pragma once

#include "raysweep/volume/grids.h"

#include <cstddef>
#include <string>

namespace raysweep {

/// The largest finite half float.
constexpr float kLargestHalf = 65504.0f;

/// Checks that no active voxel or tile is NaN, infinite or negative (in any channel). `what` names the grid in the
/// message, for instance "density". @throw InvalidArgument with the number of bad values and the first of them: leaves
/// before tiles, each in the tree's order, so the same whatever the number of threads. Its remedy is repairVoxels.
void checkVoxels(const openvdb::FloatGrid& grid, const std::string& what);
void checkVoxels(const openvdb::Vec3SGrid& grid, const std::string& what);

/// Sets active values that checkVoxels refuses to 0 (for a Vec3SGrid the bad channels only).
/// @return number of voxels changed; a tile counts as its voxels.
std::size_t repairVoxels(openvdb::FloatGrid& grid);
std::size_t repairVoxels(openvdb::Vec3SGrid& grid);

/// The same two for values that may be negative, since a transfer function classifies them: refused are NaN and
/// infinity.
void checkFinite(const openvdb::FloatGrid& grid, const std::string& what);
std::size_t repairNotFinite(openvdb::FloatGrid& grid);

/// Checks that all active values of an albedo, a FloatGrid or Vec3SGrid, are in [0,1].
/// @throw InvalidArgument as checkVoxels does, and if the grid has another type.
void checkAlbedo(const openvdb::GridBase& grid, const std::string& what = "albedo");

/// Brings active values into [0,1]; NaN becomes 0. @return number of voxels changed; a tile counts as its voxels.
std::size_t clampAlbedo(openvdb::FloatGrid& grid);
std::size_t clampAlbedo(openvdb::Vec3SGrid& grid);

/// Checks a result before it is written. @param cause what can have made values NaN or infinite, for the message
/// @throw InvalidArgument if an active value of a FloatGrid or Vec3SGrid is; other grids are passed over
void requireFiniteResult(const openvdb::GridBase& grid, const std::string& cause);

/// If the grid is to be saved as half (set that first), clamps active values to the largest half, since larger ones
/// would be stored as infinity and shown black by other programs. @return number of voxels changed.
std::size_t clampForHalf(openvdb::FloatGrid& grid);
std::size_t clampForHalf(openvdb::Vec3SGrid& grid);

/// Turns active tiles into voxels. Blender's Cycles shows nothing where all grids of a shader have only tiles.
void voxelizeTiles(openvdb::FloatGrid& grid);
void voxelizeTiles(openvdb::Vec3SGrid& grid);

}  // namespace raysweep
