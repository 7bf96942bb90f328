/// Directions in which a solution is swept.
#pragma once

#include "raysweep/core/types.h"

#include <cstdint>
#include <random>
#include <vector>

namespace raysweep {

/// How successive directions are chosen. Each direction stands for the whole sphere (weight 4 pi) in turn.
enum class DirectionSet {
    fibonacci,       ///< batches of spherical Fibonacci points, each shuffled and randomly rotated: well spread *and*
                     ///< consecutive directions independent. The default
    random,          ///< independent, uniform on the sphere
    lowDiscrepancy,  ///< plain additive recurrence (R2). Consecutive directions are correlated, which biases a solution
                     ///< with a large zeta; kept to show that
};

/// `count` points spread evenly over the unit sphere (Swinbank and Purser 2006; midpoint in z, golden angle in
/// azimuth).
std::vector<Vec3> sphericalFibonacci(int count);

/// A uniformly distributed rotation (Shoemake 1992).
Matrix3 randomRotation(std::mt19937_64& random);

/// Uniform in [0,1), the same on every platform.
double uniform01(std::mt19937_64& random);

/// An endless sequence of unit vectors in which light travels.
class DirectionSequence {
  public:
    /// @param batch points per Fibonacci batch, >= 1
    DirectionSequence(DirectionSet set, int batch, std::uint64_t seed);
    Vec3 next();

  private:
    void refill();

    DirectionSet set_;
    std::vector<Vec3> points_, shuffled_;
    std::size_t used_ = 0;
    std::uint64_t step_ = 0;
    std::mt19937_64 random_;
};

}  // namespace raysweep
