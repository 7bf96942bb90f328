/// The options of the sky: a constant radiance or a lat-long map.
#pragma once

#include "cli.h"

#include "raysweep/scene/scene_io.h"

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct SkyArguments {
    std::string sky, up = "z";
    double scale = 1, rotate = 0;
    int suns = 16;
};

void addSkyOptions(CLI::App& app, SkyArguments& arguments);

/// What was typed, as the library takes it; a map is not read yet. @throw CLI::ValidationError
SkyOptions parseSky(const SkyArguments& arguments);

}  // namespace raysweep::apps
