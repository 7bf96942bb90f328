/// TIFF as numbers. For the module of pictures.
#pragma once

#include "raysweep/image/picture_file.h"

#include <memory>
#include <string>

namespace raysweep {

/// True if the file begins as TIFFs do, whatever its name.
bool isTiff(const std::string& path);

/// Samples as they are stored: integers of up to 64 bits, floats of 16, 32 and 64. Not inverted where small numbers are
/// white. A stack that ImageJ wrote with one directory has as many pages as it has slices.
/// @throw IoError if the file is damaged, or its samples are no numbers
std::unique_ptr<PictureFile> openTiff(const std::string& path);

}  // namespace raysweep
