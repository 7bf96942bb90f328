/// Inject-and-shoot iteration (paper, section 2.2): every sweep injects all light again and moves unshot power on; the
/// answer is what has been deposited divided by the number of injections.
#pragma once

#include "raysweep/illuminate/state.h"

namespace raysweep {

/// Sweeps until the estimate stands still, and then until nothing is left unshot. Fills in all of `result` that is
/// about sweeps, and the books.
void runSweeps(Illumination& result, SolverState& state, const Scene& scene, const IlluminateOptions& options,
               const ProgressCallback& progress);

}  // namespace raysweep
