/// What `raysweep photo` says of what it did.
#pragma once

#include "photo_options.h"

#include "raysweep/camera/photograph_sets.h"
#include "raysweep/reconstruct/photo.h"
#include "raysweep/reconstruct/photo_confidence.h"
#include "raysweep/render/photo_quality.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace raysweep::apps {

/// Of each set of photographs; without views where nothing was judged.
struct Judgement {
    PhotoQuality used, heldOut, test;
    PhotoQuality directional;              ///< the held-out ones in colours of their directions, with --sh 1
    std::vector<std::size_t> standingOut;  ///< of the used ones
};

struct PhotoOutcome {
    PhotographSets sets;
    PhotoReconstruction result;
    PhotoConfidence confidence;  ///< where it was asked for
    double confidenceSeconds = 0;
    Judgement judgement;
    std::vector<std::string> warnings;
    double seconds = 0;
    std::size_t peakBytes = 0;
};

nlohmann::ordered_json describe(const PhotoArguments& arguments, const PhotoOutcome& outcome);

void plotHistory(const std::string& path, const PhotoReconstruction& result);

}  // namespace raysweep::apps
