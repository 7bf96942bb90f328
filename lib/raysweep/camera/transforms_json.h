/// The transforms.json of NeRF and Nerfstudio. For this module's own sources.
#pragma once

#include "raysweep/camera/picture_folders.h"
#include "raysweep/camera/poses.h"

#include <string>

namespace raysweep {

/// Keys that are not known are left alone: each program adds its own. @throw IoError as readPoses
Poses posesFromTransforms(const std::string& text, const PictureFolders& folders, CameraAxes axes);

/// The text of a file in `folder`; one line per frame. The cameras must be valid.
std::string transformsOf(const Poses& poses, const std::string& folder);

}  // namespace raysweep
