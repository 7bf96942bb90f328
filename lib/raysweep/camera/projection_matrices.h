/// Lists of cameras as matrices. For this module's own sources.
#pragma once

#include "raysweep/camera/picture_folders.h"
#include "raysweep/camera/poses.h"

#include <string>

namespace raysweep {

/// Middlebury's: the number of pictures, then for each a line "name K R t", matrices by rows. @throw IoError
Poses posesFromMiddlebury(const std::string& text, const PictureFolders& folders, CameraAxes axes);

/// A line "name P" for each picture, P the 3x4 projection matrix by rows, of any scale. @throw IoError
Poses posesFromProjections(const std::string& text, const PictureFolders& folders, CameraAxes axes);

}  // namespace raysweep
