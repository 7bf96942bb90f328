/// How much memory this process holds.
#pragma once

#include <cstddef>
#include <string>

namespace raysweep {

std::size_t residentBytes();      ///< now; 0 where the system does not say
std::size_t peakResidentBytes();  ///< the most so far, or since resetPeak; 0 where the system does not say
std::size_t physicalBytes();      ///< of the machine
void resetPeak();                 ///< where the system allows it

/// @throw InvalidArgument "WHAT 12 GB, this machine has 8 GB; INSTEAD" if the machine has less than `bytes`.
void requireBytes(double bytes, const std::string& what, const std::string& instead);

/// The same for a volume of `blocks` blocks of 8x8x8 voxels: leaves, bricks.
void requireMemory(double blocks, std::size_t bytesPerVoxel);

}  // namespace raysweep
