/// One call from poses and the picture files they name to photographs freed of their backdrop.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/camera/poses.h"
#include "raysweep/core/progress.h"
#include "raysweep/image/matting.h"

#include <string>
#include <vector>

namespace raysweep {

struct PhotographOptions {
    MattingOptions matting;
    /// masks: where a picture's mask is looked for, by the picture's name (NAME, NAME.png, or its name with another
    /// extension); empty: those that the poses name.
    std::string maskFolder;
    int reduction = 1;        ///< pictures are made smaller by this factor, means over squares of pixels, in [1,64]
    std::string matteFolder;  ///< where a picture of each matte is written (mattePicture), for people; empty: nowhere

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// What is possible, but hardly meant.
struct PhotographWarning {
    enum class Kind {
        oneView,         ///< nothing says how far away the object is
        emptyViews,      ///< views that show nothing of the object
        fullViews,       ///< views in which every pixel is the object's: the backdrop was not told from it
        inconsistent,    ///< views with more than a hundredth of the object's pixels inconsistent
        misregistration  ///< pairs in which the object, or the camera, has moved
    };
    Kind kind;
    std::string message;
};

struct Photographs {
    std::vector<Photograph> views;     ///< in the order of the poses
    std::vector<MatteReport> reports;  ///< of each view, before it was made smaller
    std::vector<PhotographWarning> warnings;
    double seconds = 0;
    bool complete = true;  ///< false if reading was stopped: then there are no views
};

/// Reads the picture or the pictures of each view, checks them against the camera, makes the matte, and reduces both.
/// Before a white or black backdrop that is the pose's `onWhite` or `onBlack`, else its `image`; a pair needs both.
/// @throw InvalidArgument as the options' validate() and the method of matting, naming the picture; for pictures whose
/// size is no even multiple of the camera's, naming both; if a pair is not complete or a mask missing; if there are no
/// views, or none shows anything of the object.
/// @throw IoError as readImage.
Photographs readPhotographs(const Poses& poses, const PhotographOptions& options = {},
                            const ProgressCallback& progress = {});

}  // namespace raysweep
