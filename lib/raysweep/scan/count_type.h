/// Counts that were stored as numbers of a wrong type.
#pragma once

#include "raysweep/core/sample_type.h"

#include <cstddef>
#include <string>

namespace raysweep {

/// Adds what was lost to counts below 0 that an integer type with a sign could not hold: 2^bits. Nothing of other
/// types.
void addWrapped(float* values, std::size_t count, SampleType type);

/// @param what the file, for messages
/// @throw InvalidArgument if `least`, the least of some counts, is so far below 0 that it can only be one of a type
/// without a sign: more than a tenth of what the type with one reaches to.
void requireCounts(double least, SampleType type, const std::string& what);

}  // namespace raysweep
