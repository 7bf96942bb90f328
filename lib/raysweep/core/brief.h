/// Numbers in messages.
#pragma once

#include <cstdio>
#include <string>

namespace raysweep {

/// A number as people write it, with few digits.
inline std::string brief(double value, int digits = 2) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

}  // namespace raysweep
