/// The escape probability of a voxel: what decides how much of the power scattered inside it gets out.
#pragma once

#include "raysweep/core/types.h"

#include <vector>

namespace raysweep {

/// p(t) as a ratio of polynomials, for kernels: p ~ (1 + b1 t + b2 t^2 + b3 t^3) / (1 + a1 t + ... + a4 t^4), with
/// all coefficients >= 0, so that it has no pole, 0 < p <= 1, and the right value and slope at both ends.
struct EscapeFit {
    float a[4] = {0, 0, 0, 0};
    float b[3] = {0, 0, 0};
    double maxRelativeError = 0;  ///< over t in [1e-3, 1e4]

    double numerator(double t) const { return 1 + t * (b[0] + t * (b[1] + t * b[2])); }
    double denominator(double t) const { return 1 + t * (a[0] + t * (a[1] + t * (a[2] + t * a[3]))); }
    double probability(double t) const { return numerator(t) / denominator(t); }
};

/// Step lengths of a voxel over all directions, and what follows from them.
///
/// p(t) = < (1 - exp(-t l)) / (t l) >, the mean over directions of the probability that power emitted uniformly along a
/// ray's stretch in the voxel leaves it without colliding; l = step length / mean step length, t = extinction * mean
/// step length. A function of t alone for a given shape of voxel (physics: docs/illumination.md).
class Escape {
  public:
    /// @param worldFromIndex linear part of the grid's transform
    explicit Escape(const Matrix3& worldFromIndex);

    /// Of voxels of the same shape, `factor` times as long.
    Escape scaled(double factor) const;

    double meanStepLength() const { return meanStepLength_; }  ///< world units
    double meanInverseLength() const { return meanInverse_; }  ///< <1/l>
    /// Exact p, interpolated in a table to 1e-5.
    double probability(double t) const { return 1 / inverseProbability(t); }
    double inverseProbability(double t) const;  ///< 1/p
    /// The same by quadrature, for tests and the table.
    double probabilityByQuadrature(double t) const;
    const EscapeFit& fit() const { return fit_; }

  private:
    void fillTable();

    std::vector<double> lengths_;  ///< quantiles of l, equally likely
    double meanStepLength_ = 0, meanInverse_ = 0;
    struct Node {
        double t, inverse, slope = 0;  ///< 1/p there, and from there to the next node
    };
    std::vector<Node> table_;
    EscapeFit fit_;
};

/// Effective albedo of a voxel: the closed sum of all scatterings inside it, albedo p / (1 - albedo (1 - p)).
inline double effectiveAlbedo(double albedo, double p) {
    return albedo * p / (1 - albedo * (1 - p));
}

}  // namespace raysweep
