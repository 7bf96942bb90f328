/// EXR pictures.
#pragma once

#include "raysweep/image/image.h"
#include "raysweep/image/picture_file.h"

#include <memory>
#include <string>

namespace raysweep {

/// True if the file begins as an EXR does, whatever its name.
bool isExr(const std::string& path);

/// Scanlines or tiles, one part or several (each is a page), any channels of one sample per pixel. Of tiles with
/// several levels the finest. Channels are in alphabetical order of layers, in each R, G, B, Y, A, Z before others.
/// @return null for files with deep or subsampled parts, which this does not read
/// @throw IoError if the file is damaged
std::unique_ptr<PictureFile> openExr(const std::string& path);

/// 32 bit floats. @param path what messages call the file that is written to `temporary` @throw IoError
void writeExr(const std::string& path, const std::string& temporary, const Image& image);

}  // namespace raysweep
