/// What the rays of a sweep carry in and out.
#pragma once

#include "raysweep/core/types.h"

namespace raysweep {

/// Ray powers summed over a beam's rays at both ends, in the unit of the rays' power.
struct RaySums {
    double entered[kMaxChannels] = {0};
    double escaped[kMaxChannels] = {0};
};

}  // namespace raysweep
