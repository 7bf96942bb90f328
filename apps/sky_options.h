/// The options of the sky: a constant radiance or a lat-long map.
#pragma once

#include "cli.h"

#include "raysweep/scene/scene.h"

#include <optional>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct SkyArguments {
    std::string sky, up = "z";
    double scale = 1, rotate = 0;
    int suns = 16;
};

void addSkyOptions(CLI::App& app, SkyArguments& arguments);

/// Checks what was typed. @throw CLI::ValidationError
void checkSky(const SkyArguments& arguments);

/// What suns that stand for bright parts of a map amount to.
struct SkySuns {
    int count = 0;
    double share = 0;  ///< of the map's power
};

/// Adds the sky to the scene, and the suns that stand for bright parts of a map.
/// @return for a map, what those are
/// @throw IoError, InvalidArgument for a map that cannot be read or used
std::optional<SkySuns> addSky(const SkyArguments& arguments, Scene& scene);

}  // namespace raysweep::apps
