/// Whole files, for tests that look at bytes or change them.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace raysweep::test {

inline std::string contentsOf(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Folders are made as needed.
inline void writeBytes(const std::filesystem::path& path, const std::string& bytes) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes;
}

/// Files and folders in a folder.
inline std::size_t entriesOf(const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace raysweep::test
