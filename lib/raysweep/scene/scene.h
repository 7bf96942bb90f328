/// What is to be lit, and by what.
#pragma once

#include "raysweep/scene/light.h"
#include "raysweep/volume/medium.h"
#include "raysweep/volume/resample.h"

#include <vector>

namespace raysweep {

struct Scene {
    Medium medium;
    std::vector<Sun> suns;
    std::vector<PointLight> points;
    std::vector<QuadLight> quads;
    Sky sky;

    /// @throw InvalidArgument naming field, value and bound for anything that has no meaning: no density, an extinction
    ///        that is negative or not finite, an albedo outside [0,1], a sun without direction, negative light, ...
    void validate() const;
};

/// The scene with its medium on voxels 1/resolution times as long; lights stay as they are.
/// @throw InvalidArgument as atResolution(medium, resolution) does
inline Scene atResolution(Scene scene, double resolution) {
    scene.medium = atResolution(scene.medium, resolution);
    return scene;
}

}  // namespace raysweep
