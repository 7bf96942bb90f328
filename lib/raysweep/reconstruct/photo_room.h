/// Whether a volume of photographs has room in memory.
#pragma once

#include <cstddef>

namespace raysweep {

/// @param voxels of bricks that are yet to be allocated  @param bytesPerVoxel of each of them
/// @throw InvalidArgument if they and what the process holds already, photographs above all, need more memory than
/// there is (core/memory.h)
void requireRoom(double voxels, std::size_t bytesPerVoxel);

}  // namespace raysweep
