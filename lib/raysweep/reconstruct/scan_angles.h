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

/// Views from one angle, as those of a detector that is moved aside between exposures.
struct ScanDirection {
    double angle = 0;                  ///< radians modulo the period; a little below 0 if some views of it are
    std::size_t first = 0, count = 0;  ///< of `ScanAngles::order`
    double weight = 0;                 ///< radians: half the gaps to its two neighbours
};

struct ScanAngles {
    std::vector<std::size_t> order;         ///< views by their angle modulo the period
    std::vector<ScanDirection> directions;  ///< ascending
    std::vector<double> weights;            ///< of each view, radians: an equal share of its direction's
    std::vector<ScanArc> arcs;              ///< what the views cover; one of the whole period if closed
    double arc = 0;                         ///< length of all arcs together: the sum of the weights
    bool closed = true;                     ///< covers all of the period
};

/// Angles in radians, in any order, count modulo `period`: pi for parallel rays, which measure the same from both
/// sides, else 2 pi. A gap five times as wide as the narrower ones are on average is one that the scan leaves out:
/// nobody stands for it. Views that are less than a thousandth of the mean gap apart share a direction: how many views
/// there are from one angle does not say how much of the turn it stands for. At least 2 angles.
/// @param widest radians: gaps up to it are never left out
ScanAngles scanAngles(const std::vector<double>& angles, double period, double widest = 0);

}  // namespace raysweep
