/// Whether a volume of photographs has room in memory.
#pragma once

#include <cstddef>

namespace raysweep {

/// Whether there is memory (core/memory.h) for what the process holds already, photographs above all, and more.
/// @param voxels of bricks that are yet to be allocated  @param bytesPerVoxel of each of them
bool hasRoom(double voxels, std::size_t bytesPerVoxel);

/// @throw InvalidArgument unless hasRoom
void requireRoom(double voxels, std::size_t bytesPerVoxel);

}  // namespace raysweep
