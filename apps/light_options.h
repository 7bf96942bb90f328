/// The options of `raysweep light`, as typed and as understood.
#pragma once

#include "cli.h"
#include "sky_options.h"
#include "transfer_options.h"

#include "raysweep/illuminate/illuminate.h"
#include "raysweep/volume/vdb_io.h"

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
    std::string commandLine;    ///< all options with their values, for metadata and report
    std::size_t peakBytes = 0;  ///< most memory used while solving, above what was in use before
};

void addLightOptions(CLI::App& app, LightArguments& arguments);

/// Checks what can be checked without the input, and fills in what follows from other options.
/// @throw CLI::ValidationError for values that cannot be understood
void completeOptions(LightArguments& arguments);

/// What the arguments and the input come to.
struct LightScene {
    Scene scene;
    std::string density;  ///< the grid that was chosen, by a name that chooses it again
    std::optional<TransferFunction> transfer;
    bool ownExtinction = false;        ///< the extinction is no multiple of that grid, so the output must hold it
    std::optional<SkySuns> skySuns;    ///< that stand for bright parts of a sky map; none without a map
    std::vector<std::string> reasons;  ///< what is modelled and why, one line each; the solver's plan has more
};

/// The scene the arguments describe. Repairs voxels if asked to.
/// @throw InvalidArgument if grids are missing or not of the kind that is needed
LightScene buildScene(const LightArguments& arguments, const VdbFile& file);

}  // namespace raysweep::apps
