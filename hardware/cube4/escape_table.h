/// The escape probability of a voxel (docs/illumination.md, eq. L3), found by the emulator's own means: a table that
/// stands for the look-up table of hardware.
///
///     p(σ) = ⟨(1 - exp(-σ len)) / (σ len)⟩ over directions, len = 1 / |ω M⁻¹|_major
#pragma once

#include "raysweep/core/types.h"

#include <vector>

namespace raysweep::cube4 {

class EscapeTable {
  public:
    /// @param worldFromIndex linear part of the grid's transform, M
    explicit EscapeTable(const Matrix3& worldFromIndex);

    /// @param extinction 1/world unit, not negative
    double probability(double extinction) const;

    double meanLength() const { return mean_; }                ///< ⟨len⟩, world units
    double meanInverseLength() const { return meanInverse_; }  ///< ⟨1 / len⟩, 1/world unit

  private:
    std::vector<double> lengths_;  ///< quantiles of len
    double mean_ = 0, meanInverse_ = 0, unit_ = 1;
    std::vector<double> table_;  ///< p at σ = e^x / unit, x evenly spaced
};

/// Of power emitted in a voxel the part that leaves it after any number of scatterings inside; times the albedo it is
/// the effective albedo (eq. L4).
inline double leavingPart(double albedo, double escape) {
    return escape / (1 - albedo * (1 - escape));
}

}  // namespace raysweep::cube4
