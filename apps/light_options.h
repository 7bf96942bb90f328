/// The options of `raysweep light`, as typed and as understood.
#pragma once

#include "cli.h"

#include "raysweep/illuminate/illuminate.h"
#include "raysweep/volume/vdb_io.h"

#include <optional>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct LightArguments {
    CommonOptions common;
    IlluminateOptions options;
    std::string input, output, density, albedo = "0.9", emission, sky, plot;
    std::string exchange = "auto", quality;
    std::vector<std::string> suns, points;
    double extinction = 1, emissionScale = 1, skyScale = 1, resolution = 1;
    std::optional<double> tolerance;
    bool fromLevelSet = false, repair = false, half = false, explain = false, upsample = false;
    int snapshots = 0;
    std::string commandLine;    ///< all options with their values, for metadata and report
    std::size_t peakBytes = 0;  ///< most memory used while solving, above what was in use before
};

void addLightOptions(CLI::App& app, LightArguments& arguments);

/// Checks what can be checked without the input, and fills in what follows from other options.
/// @throw CLI::ValidationError for values that cannot be understood
void completeOptions(LightArguments& arguments);

/// The scene the arguments describe. Repairs voxels if asked to.
/// @throw InvalidArgument if grids are missing or not of the kind that is needed
Scene buildScene(const LightArguments& arguments, const VdbFile& file);

}  // namespace raysweep::apps
