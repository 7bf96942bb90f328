/// What a scene requires.
#pragma once

#include "raysweep/illuminate/options.h"
#include "raysweep/scene/scene.h"

#include <string>
#include <vector>

namespace raysweep {

/// What will be modelled, and why: only what the scene requires.
struct Plan {
    int channels = 1;         ///< wavelengths: 1 if everything is grey, else 3
    bool directPass = false;  ///< suns or points
    bool sweeps = false;      ///< anything can scatter, and there is light to scatter
    bool unshotGrid = false;
    bool surfaces = false;             ///< normals are found, and the local furnace is measured
    std::vector<std::string> reasons;  ///< one line each
};

Plan planIllumination(const Scene& scene, const IlluminateOptions& options);

}  // namespace raysweep
