/// A front with what goes with its direction, and what its rays carry when they enter the volume.
#pragma once

#include "raysweep/sweep/ray_front.h"

namespace raysweep {

struct Beam {
    RayFront front;
    float stepScale = 1;                 ///< step length / mean step length
    float entering[kMaxChannels] = {0};  ///< power of a ray when it enters the volume, any unit of power
    float furnaceRay = 1;                ///< what a ray of radiance 1 adds to the local furnace
};

}  // namespace raysweep
