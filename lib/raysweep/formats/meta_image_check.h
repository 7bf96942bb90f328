/// What ITK does not check of MetaImage files. Nothing but itk_volume.cpp includes it.
#pragma once

#include <string>

namespace raysweep {

/// @throw IoError if `path` does not start with a header of lines "Key = value" that ends with ElementDataFile.
void checkMetaImage(const std::string& path);

}  // namespace raysweep
