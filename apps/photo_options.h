/// What `raysweep photo` is told.
#pragma once

#include "cli.h"

#include "raysweep/camera/photograph_files.h"
#include "raysweep/camera/poses.h"
#include "raysweep/render/shading.h"

#include <optional>
#include <string>

namespace raysweep::apps {

/// What the user typed; empty text: not given. Whole after completeOptions, but for what only the files say.
struct PhotoArguments {
    CommonOptions common;
    std::string input, output, axes, matting, test, bounds, light, method, reference, plot, compareViews;
    PoseOptions poses;
    PhotographOptions photographs;
    bool mattingGiven = false;  ///< else it is chosen by what the pictures have
    int size = 0, holdOut = 0, historyEvery = 0, sh = 0;
    std::optional<int> iterations;
    std::optional<double> relaxation, ambient, smooth;
    Shading shading;  ///< of the photographs, but for its direction
    std::optional<Box3> box;
    std::optional<Vec3> lightInWorld;  ///< in the first view
    bool findLight = false, lampStands = false, half = false, refinePoses = false, confidence = false;
    double backdrop = 1;
};

void addPhotoOptions(CLI::App& command, PhotoArguments& arguments);

/// Everything that can be said to be wrong before a file is read. @throw CLI::ValidationError
void completeOptions(PhotoArguments& arguments, const CLI::App& command);

}  // namespace raysweep::apps
