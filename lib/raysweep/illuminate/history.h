/// How an iteration goes and ends.
#pragma once

namespace raysweep {

enum class Termination {
    converged,    ///< the tolerance was met, or with tolerance 0 all sweeps were made
    sweepLimit,   ///< `sweeps` was reached first
    interrupted,  ///< the progress callback said stop; the answer is what there was
    direct        ///< nothing needed a sweep
};

struct ConvergencePoint {
    int sweep;
    double rms;          ///< relative RMS difference to the estimate 20 sweeps before
    double unshotShare;  ///< unshot power as part of the power injected so far
};

}  // namespace raysweep
