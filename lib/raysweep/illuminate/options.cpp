#include "raysweep/illuminate/options.h"

#include "raysweep/core/require.h"
#include "raysweep/sweep/exchange.h"

#include <cmath>

namespace raysweep {

void IlluminateOptions::validate() const {
    const auto notNegative = [](double value) { return value >= 0 && std::isfinite(value); };
    const auto isPart = [](double value) { return value > 0 && value <= 1; };
    requireField(isPart(zeta.value_or(1)), "zeta", zeta.value_or(1), "in (0, 1]");
    requireField(notNegative(tolerance), "tolerance", tolerance, "0 or more, and finite");
    requireField(sweeps >= 0, "sweeps", sweeps, "0 or more");
    requireField(isPart(unshotShare), "unshot share", unshotShare, "in (0, 1]");
    requireField(batch >= 0 && batch <= 100000, "batch", batch, "0 to 100000");
    requireField(beams >= 0 && beams <= kMostBeams, "beams", beams, "0 to " + std::to_string(kMostBeams));
    requireField(isPart(surfaceThreshold), "surface threshold", surfaceThreshold, "in (0, 1]");
    requireField(snapshotEvery >= 0, "snapshot interval", snapshotEvery, "0 or more");
}

}  // namespace raysweep
