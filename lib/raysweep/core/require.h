/// How options say that a field is out of bounds.
#pragma once

#include "raysweep/core/error.h"

#include <sstream>
#include <string>

namespace raysweep {

/// @throw InvalidArgument "FIELD VALUE: must be BOUND" unless `holds`.
template <class Value>
void requireField(bool holds, const std::string& field, const Value& value, const std::string& bound) {
    if (holds) return;
    std::ostringstream message;
    message << field << " " << value << ": must be " << bound;
    throw InvalidArgument(message.str());
}

}  // namespace raysweep
