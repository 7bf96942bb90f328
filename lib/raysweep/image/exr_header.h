/// What OpenEXR believes of a file before it has read any of it.
#pragma once

#include <string>

namespace raysweep {

/// OpenEXR takes memory for attributes and for tables of places as large as a header says they are; in a damaged file
/// of a few hundred bytes that is gigabytes.
/// @throw IoError if an attribute or a table is longer than the file
void requireSoundExrHeader(const std::string& path);

}  // namespace raysweep
