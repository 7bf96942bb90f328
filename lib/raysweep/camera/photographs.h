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

}  // namespace raysweep
