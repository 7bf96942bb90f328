/// What part of the turn each view of a scan stands for, Δθ and Δβ of fbp.h, and Parker's weights of short scans.
#pragma once

#include <vector>

namespace raysweep {

struct ScanAngles {
    std::vector<double> weights;  ///< of each view, radians: half the gaps to its two neighbours
    double begin = 0;             ///< where the scan begins, half a gap before its first view, radians
    double arc = 0;               ///< what it covers: the sum of the weights
    bool closed = true;           ///< covers all of the period
};

/// Angles in radians, in any order, count modulo `period`: pi for parallel rays, which measure the same from both
/// sides, else 2 pi. A gap five times as wide as the others are on average is one that the scan leaves out: nobody
/// stands for it. At least 2 angles.
ScanAngles scanAngles(const std::vector<double>& angles, double period);

/// Weight of a cone's ray in a scan of less than a full turn, so that each line, measured once or, from both ends,
/// twice, counts as one. D. L. Parker, "Optimal short scan convolution reconstruction for fanbeam CT", Med. Phys. 9,
/// 1982, for a scan of π + 2δ (his δ is half the fan's angle; more is allowed):
///
///     sin²(π/4 β / (δ - γ))             for 0 <= β < 2 (δ - γ)
///     1                                 up to β = π - 2γ
///     sin²(π/4 (π + 2δ - β) / (δ + γ))  up to β = π + 2δ
///
/// @param beta β, angle since the scan's begin  @param gamma γ, of the ray from the source's line to the axis; both
/// turn the same way, radians
double parkerWeight(double beta, double gamma, double delta);

}  // namespace raysweep
