/// Photographs of an object, with where they were taken from.
#pragma once

#include "raysweep/camera/photo_camera.h"
#include "raysweep/image/image.h"

#include <string>
#include <vector>

namespace raysweep {

/// One picture of the object, freed of its backdrop.
struct Photograph {
    std::string name;    ///< of the file, for messages
    PhotoCamera camera;  ///< of the size of `matte`
    Image matte;  ///< RGBA in linear light, RGB multiplied by alpha; alpha is what the object covers of the pixel
};

/// The photograph with squares of `factor` x `factor` pixels as one (matte_picture.h), and the camera that takes such.
/// Columns and rows that fill no square are left out. @throw InvalidArgument as reduced of an image
Photograph reduced(const Photograph& photograph, int factor);

/// @throw InvalidArgument if there are none, naming one that has no alpha or is not of the size that its camera has,
/// and as PhotoCamera::validate
void requireUsable(const std::vector<Photograph>& photographs);

}  // namespace raysweep
