/// What can be read more than once, and ends.
#pragma once

#include <string>

namespace raysweep {

/// Why `path` is no regular file, in words for an error; empty if it is one.
/// @param wanted what to give in place of a folder, such as "a .vdb file"
std::string whyNotRegular(const std::string& path, const std::string& wanted);

}  // namespace raysweep
