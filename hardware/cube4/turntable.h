/// A volume X-rayed and reconstructed by the machine itself: parallel views over half a turn.
#pragma once

#include "cube4/reconstruction.h"
#include "cube4/replay.h"

#include "raysweep/core/progress.h"

namespace raysweep::cube4 {

struct TurntableSetup {
    int views = 60;           ///< over 180 degrees about the world's z axis
    int passes = 5;           ///< over all views
    double relaxation = 0.5;  ///< λ, in (0,2)

    /// @throw InvalidArgument naming field, value and bound
    void validate() const;
};

struct TurntableResult {
    Agreement volume;         ///< to the volume that was X-rayed
    Agreement volumeToFloat;  ///< with a format: to the machine with floats
    DenseField field;
    std::size_t updates = 0;
    Counters project, backproject;
    std::size_t bytesPerModule = 0, bufferBytes = 0;
    bool complete = true;  ///< false: stopped by the progress callback
};

/// Views have a pixel for each voxel edge, and follow each other by a golden section of the half turn. Values stay at 0
/// or above.
TurntableResult reconstructTurning(const DenseField& volume, const DenseBox& box, const TurntableSetup& turntable,
                                   const ReplaySetup& setup, const ProgressCallback& progress = {});

}  // namespace raysweep::cube4
