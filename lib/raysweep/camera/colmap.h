/// COLMAP's sparse models. For this module's own sources.
#pragma once

#include "raysweep/camera/picture_folders.h"
#include "raysweep/camera/poses.h"

#include <string>

namespace raysweep {

/// True if the folder holds a model's cameras and images, as text or binary.
bool isColmapModel(const std::string& folder);

/// The model in `folder`; binary if there are both. Views in the natural order of their pictures' names.
/// @param pictures what was given; where COLMAP's users have them is added
/// @throw IoError as readPoses, naming the file of the model
Poses readColmap(const std::string& folder, const PictureFolders& pictures, CameraAxes axes);

}  // namespace raysweep
