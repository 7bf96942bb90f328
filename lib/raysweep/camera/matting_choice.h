/// By what the object of photographs can be told from its backdrop.
#pragma once

#include "raysweep/camera/poses.h"
#include "raysweep/image/matting.h"

#include <optional>

namespace raysweep {

/// The way that needs no guess, if there is one for all views: alpha if every picture has it, a white and a black
/// backdrop if both pictures are named, masks if they are. Everything else takes someone who has looked at a picture.
/// @throw IoError as readImage for the pictures
std::optional<MattingOptions::Matting> evidentMatting(const Poses& poses);

}  // namespace raysweep
