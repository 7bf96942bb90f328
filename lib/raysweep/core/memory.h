/// How much memory this process holds.
#pragma once

#include "raysweep/core/error.h"

#include <cstddef>
#include <istream>
#include <string>

namespace raysweep {

std::size_t residentBytes();      ///< now; 0 where the system does not say
std::size_t peakResidentBytes();  ///< the most so far, or since resetPeak; 0 where the system does not say
std::size_t physicalBytes();      ///< of the machine, or what its control groups leave this process of it
void resetPeak();                 ///< where the system allows it

/// The least limit that Linux's control groups, version 1 or 2, set a process; infinite if there is none.
/// @param groups as /proc/self/cgroup says them  @param root where their files are: /sys/fs/cgroup
double groupLimit(std::istream& groups, const std::string& root);

/// @throw InvalidArgument "WHAT 12.3 GB, there are 8.1 GB; INSTEAD" if there is less than `bytes` (physicalBytes).
/// @param remedy of the error; what a program adds stands at its end
void requireBytes(double bytes, const std::string& what, const std::string& instead, Remedy remedy = Remedy::none);

/// The same for a volume of `blocks` blocks of 8x8x8 voxels: leaves, bricks.
void requireMemory(double blocks, std::size_t bytesPerVoxel);

}  // namespace raysweep
