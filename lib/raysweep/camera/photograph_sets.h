/// One call from files to the photographs that a volume is made of, and to those that judge it.
#pragma once

#include "raysweep/camera/photograph_files.h"
#include "raysweep/camera/poses.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

struct PhotographSetOptions {
    PoseOptions poses;
    PhotographOptions photographs;
    bool chooseMatting = true;   ///< by evidentMatting, in place of `photographs.matting.matting`
    int holdOut = 0;             ///< views K-1, 2K-1, ... only judge, at least 2; 0: none
    std::string test;            ///< poses of more views that only judge, read as the others are; empty: none
    std::optional<Box3> bounds;  ///< of the object, where cameras should look; else estimated

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

struct PhotographSet {
    std::vector<Photograph> views;
    std::vector<MatteReport> mattes;  ///< of each view, before it was made smaller
};

struct PhotographSets {
    PhotographSet used, heldOut, test;
    Poses poses;                 ///< of `used`, as the files say them
    std::optional<Box3> bounds;  ///< of the object: the options', else what the silhouettes of `used` leave of
                                 ///< estimatedBounds; none if that cannot be said
    MattingOptions::Matting matting = MattingOptions::Matting::alpha;  ///< the way that was taken
    std::vector<std::string> warnings;                                 ///< what is possible, but hardly meant
    double seconds = 0;
    bool complete = true;  ///< false if reading was stopped: then there are no views
};

/// @param input as for readPoses
/// @throw InvalidArgument as the options' validate() and readPhotographs; if nothing evident says how to tell the
/// object from its backdrop (Remedy::chooseMatting); if nearly all cameras look away from it, but would not with the
/// other convention of axes (Remedy::useOpenGlAxes, useOpenCvAxes); if there are fewer views than `holdOut`
/// @throw IoError as readPoses and readPhotographs
PhotographSets readPhotographSets(const std::string& input, const PhotographSetOptions& options = {},
                                  const ProgressCallback& progress = {});

}  // namespace raysweep
