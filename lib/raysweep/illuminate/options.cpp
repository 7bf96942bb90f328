#include "raysweep/illuminate/options.h"

#include "raysweep/core/error.h"

#include <cmath>
#include <sstream>

namespace raysweep {
namespace {

void requireBetween(const char* field, double value, double low, double high, bool openLow = false) {
    if (std::isfinite(value) && (openLow ? value > low : value >= low) && value <= high) return;
    std::ostringstream message;
    message << field << " is " << value << "; it must be in " << (openLow ? "(" : "[") << low << ", " << high << "]";
    throw InvalidArgument(message.str());
}

}  // namespace

void IlluminateOptions::validate() const {
    if (zeta) requireBetween("zeta", *zeta, 0, 1, true);
    requireBetween("tolerance", tolerance, 0, 1e30);
    requireBetween("sweeps", sweeps, 0, 1e9);
    requireBetween("unshot share", unshotShare, 0, 1, true);
    requireBetween("batch", batch, 1, 1e5);
    requireBetween("beams", beams, 0, kMostBeams);
    requireBetween("surface threshold", surfaceThreshold, 0, 1, true);
    requireBetween("snapshot interval", snapshotEvery, 0, 1e9);
}

}  // namespace raysweep
