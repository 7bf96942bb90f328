/// From the options of `raysweep light` and a file to a scene.
#pragma once

#include "light_options.h"

#include "raysweep/volume/vdb_io.h"

namespace raysweep::apps {

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
