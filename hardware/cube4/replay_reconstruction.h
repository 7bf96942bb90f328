/// A recorded run of `raysweep ct` once more, in the dense machine.
#pragma once

#include "cube4/reconstruction.h"
#include "cube4/record.h"
#include "cube4/replay.h"

#include "raysweep/core/progress.h"

namespace raysweep::cube4 {

struct ReconstructionReplay {
    Agreement volume;         ///< to the software
    Agreement volumeToFloat;  ///< with a format: to the machine with floats
    DenseField field;
    std::vector<double> residuals;  ///< RMS of p - A x of each update, over the rays that were used
    bool alignedRays = false;       ///< the machine's rays are those of the detector's pixels, in all views
    bool complete = true;           ///< false: stopped by the progress callback
    Counters project, backproject;
    std::size_t passes = 0, voxels = 0;  ///< passes of each of the two; voxels of a pass
    std::size_t bytesPerModule = 0, bufferBytes = 0;
    double seconds = 0;
};

/// @throw InvalidArgument for runs that the machine cannot do: several views in an update, total variation
ReconstructionReplay replay(const ReconstructionRecord& record, const ReplaySetup& setup,
                            const ProgressCallback& progress = {});

}  // namespace raysweep::cube4
