/// Inject-and-shoot iteration (paper, section 2.2): every sweep injects all light again and moves unshot power on; the
/// answer is what has been deposited divided by the number of injections.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/illuminate/history.h"
#include "raysweep/illuminate/state.h"

#include <vector>

namespace raysweep {

/// What is to be swept, and who wants to know.
struct SweepJob {
    const Scene& scene;
    const IlluminateOptions& options;
    const ProgressCallback& progress;
};

/// How it went; see Illumination.
struct SweepRecord {
    Termination termination = Termination::direct;
    std::vector<ConvergencePoint> history;
    int sweeps = 0, finishingSweeps = 0;
    double coarseSweeps = 0;
    double coarseSeconds = 0, sweepSeconds = 0, finishSeconds = 0;
};

/// Sweeps until the estimate stands still, and then until nothing is left unshot.
SweepRecord runSweeps(SolverState& state, const SweepJob& job);

}  // namespace raysweep
