/// What part of the turn each view of a scan stands for, Δθ and Δβ of fbp.h, and which parts nobody stands for.
#pragma once

#include <cstddef>
#include <vector>

namespace raysweep {

/// A part of the turn that views cover without a gap, radians.
struct ScanArc {
    double begin = 0;   ///< half a gap before its first view, in [0, period)
    double length = 0;  ///< in (0, period]
};

struct ScanAngles {
    std::vector<double> weights;     ///< of each view, radians: half the gaps to its two neighbours
    std::vector<std::size_t> order;  ///< views by their angle modulo the period
    std::vector<ScanArc> arcs;       ///< what the views cover; one of the whole period if closed
    double arc = 0;                  ///< length of all arcs together: the sum of the weights
    bool closed = true;              ///< covers all of the period
};

/// Angles in radians, in any order, count modulo `period`: pi for parallel rays, which measure the same from both
/// sides, else 2 pi. A gap five times as wide as the narrower ones are on average is one that the scan leaves out:
/// nobody stands for it. At least 2 angles.
/// @param widest radians: gaps up to it are never left out
ScanAngles scanAngles(const std::vector<double>& angles, double period, double widest = 0);

}  // namespace raysweep
