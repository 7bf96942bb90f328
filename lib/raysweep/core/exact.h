/// Numbers in files.
#pragma once

#include <charconv>
#include <string>

namespace raysweep {

/// The fewest digits that it takes to read the same number again.
inline std::string exact(double number) {
    char text[32];
    return std::string(text, std::to_chars(text, text + sizeof text, number == 0 ? 0.0 : number).ptr);
}

}  // namespace raysweep
