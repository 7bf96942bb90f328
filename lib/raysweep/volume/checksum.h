/// Telling volumes apart by a number.
#pragma once

#include "raysweep/volume/grids.h"

#include <string>

namespace raysweep {

/// The 64-bit FNV-1a hash, as 16 hexadecimal digits, of the active voxels in the order of their coordinates (x, then y,
/// then z): of each x, y and z as 32-bit integers and the value as a 32-bit float, all little-endian. Tiles count as
/// their voxels, values of 0 as others; name, transform and background do not count. A grid that was read from a file
/// and is written again keeps it, whether as floats or as half floats. Memory: 32 bytes for each block of 8x8x8 voxels.
/// Source: G. Fowler, L. C. Noll and K.-P. Vo, RFC 9923.
std::string checksum(const openvdb::FloatGrid& grid);

}  // namespace raysweep
