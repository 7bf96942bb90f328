/// The escape probability of a voxel: what decides how much of the power scattered inside it gets out.
#pragma once

#include "raysweep/core/types.h"

#include <vector>

namespace raysweep {

/// p(t) as a ratio of polynomials: p ~ (1 + b1 t + ... + b5 t^5) / (1 + a1 t + ... + a6 t^6), with all coefficients
/// >= 0, so that it has no pole, 0 < p <= 1, and the right value and slope at both ends. The exchange, the answer and
/// the balance of power all use this one p: what one of them takes to be absorbed is so for the others.
struct EscapeFit {
    static constexpr int kDegree = 5;  ///< of the numerator; the denominator's is one more
    float a[kDegree + 1] = {0};
    float b[kDegree] = {0};
    double maxRelativeError = 0;  ///< over t in [1e-3, 1e4]

    /// @tparam Real float, for t up to kThickest, or double
    template <class Real>
    Real probability(Real t) const {
        return polynomial(b, t) / polynomial(a, t);
    }
    /// 1 - p without cancellation, to the same relative error for the smallest t.
    double collision(double t) const {
        double sum = double(a[kDegree]);
        for (int k = kDegree; k-- > 0;) sum = double(a[k]) - double(b[k]) + t * sum;
        return t * sum / polynomial(a, t);
    }
    /// 1 + c[0] t + ... + c[n - 1] t^n
    template <class Real, int n>
    static Real polynomial(const float (&c)[n], Real t) {
        Real sum = Real(c[n - 1]);
        for (int k = n - 1; k-- > 0;) sum = Real(c[k]) + t * sum;
        return 1 + t * sum;
    }
};

/// Largest t for kernels: the fit's t^6 is within the range of floats.
constexpr float kThickest = 1e6f;

/// Step lengths of a voxel over all directions, and what follows from them.
///
/// p(t) = < (1 - exp(-t l)) / (t l) > (docs/illumination.md, eq. L3), the mean over directions of the probability that
/// power emitted uniformly along a ray's stretch in the voxel leaves it without colliding; l = step length / mean step
/// length, t = extinction * mean step length. A function of t alone for a given shape of voxel.
class Escape {
  public:
    /// @param worldFromIndex linear part of the grid's transform
    explicit Escape(const Matrix3& worldFromIndex);

    /// Of voxels of the same shape, `factor` times as long.
    Escape scaled(double factor) const;

    double meanStepLength() const { return meanStepLength_; }  ///< world units
    double meanInverseLength() const { return meanInverse_; }  ///< <1/l>
    const EscapeFit& fit() const { return fit_; }
    /// p by quadrature, to 1e-5: what the fit is fitted to.
    double probabilityByQuadrature(double t) const;

  private:
    std::vector<double> lengths_;  ///< quantiles of l, equally likely
    double meanStepLength_ = 0, meanInverse_ = 0;
    EscapeFit fit_;
};

/// Of power emitted in a voxel, the part that leaves it, after any number of scatterings inside: their closed sum
/// p / (1 - albedo (1 - p)). Times the albedo it is the effective albedo g (docs/illumination.md, eq. L4).
inline double leavingShare(double albedo, double p) {
    return p / (1 - albedo * (1 - p));
}

}  // namespace raysweep
