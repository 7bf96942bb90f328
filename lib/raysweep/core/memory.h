/// How much memory this process holds.
#pragma once

#include <cstddef>

namespace raysweep {

std::size_t residentBytes();      ///< now; 0 where the system does not say
std::size_t peakResidentBytes();  ///< the most so far, or since resetPeak; 0 where the system does not say
std::size_t physicalBytes();      ///< of the machine
void resetPeak();                 ///< where the system allows it

}  // namespace raysweep
