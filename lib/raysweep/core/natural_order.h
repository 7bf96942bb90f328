/// The order in which people count files.
#pragma once

#include <string>

namespace raysweep {

/// True if `a` comes before `b` when runs of digits count as numbers: slice2 before slice10.
bool naturallyBefore(const std::string& a, const std::string& b);

}  // namespace raysweep
