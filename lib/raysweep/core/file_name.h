#pragma once

#include <cctype>
#include <filesystem>
#include <string>

namespace raysweep {

/// The extension of a path with its dot, in small letters; empty without one.
inline std::string lowerExtension(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

}  // namespace raysweep
