/// The options of `raysweep light`, as typed and as understood.
#pragma once

#include "cli.h"
#include "sky_options.h"
#include "transfer_options.h"

#include "raysweep/illuminate/illuminate.h"

#include <optional>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct LightArguments {
    CommonOptions common;
    IlluminateOptions options;
    std::string input, output, density, albedo, emission, plot;
    TransferArguments transfer;
    SkyArguments sky;
    std::string quality;
    std::vector<std::string> suns, points, quads;
    double extinction = 1, emissionScale = 1, resolution = 1, g = 0;
    std::optional<double> tolerance;
    bool fromLevelSet = false, repair = false, half = false, explain = false, upsample = false;
    int snapshots = 0;
    // Filled in by completeOptions:
    std::string albedoGrid, emissionGrid;  ///< names; empty: none
    Color uniformAlbedo = grey(0.9f);      ///< without a grid
    std::vector<Sun> sunLights;
    std::vector<PointLight> pointLights;
    std::vector<QuadLight> quadLights;

    std::string commandLine;    ///< all options with their values, for metadata and report
    std::size_t peakBytes = 0;  ///< most memory used while solving, above what was in use before
};

void addLightOptions(CLI::App& app, LightArguments& arguments);

/// Checks what can be checked without the input, and fills in what follows from other options.
/// @throw CLI::ValidationError for values that cannot be understood
void completeOptions(LightArguments& arguments);

}  // namespace raysweep::apps
