/// The options of `raysweep light`, as typed and as understood.
#pragma once

#include "cli.h"
#include "sky_options.h"
#include "transfer_options.h"

#include "raysweep/illuminate/illuminate.h"
#include "raysweep/scene/scene_io.h"

#include <optional>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct LightArguments {
    CommonOptions common;
    IlluminateOptions options;
    SceneOptions scene;  ///< completed by completeOptions, but for a table that is to be read
    std::string input, output, albedo, emission, fire, plot, record;
    TransferArguments transfer;
    SkyArguments sky;
    std::string quality;
    std::vector<std::string> suns, points, quads;
    double resolution = 1;
    std::optional<double> tolerance;
    bool half = false, explain = false, upsample = false;
    int snapshots = 0;

    std::string commandLine;    ///< all options with their values, for metadata and report
    std::size_t peakBytes = 0;  ///< most memory used while solving, above what was in use before
};

void addLightOptions(CLI::App& app, LightArguments& arguments);

/// Checks what can be checked without the input, and fills in what follows from other options.
/// @throw CLI::ValidationError for values that cannot be understood
void completeOptions(LightArguments& arguments, const CLI::App& command);

}  // namespace raysweep::apps
