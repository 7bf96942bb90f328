/// Directions in which a solution is swept.
#pragma once

#include "raysweep/core/types.h"

#include <cstdint>
#include <random>
#include <vector>

namespace raysweep {

/// How successive directions are chosen. Each direction stands for the whole sphere (weight 4 pi) in turn.
enum class DirectionSet {
    fibonacci,  ///< batches of spherical Fibonacci points, each shuffled, randomly rotated and as large as all before
                ///< together: well spread *and* consecutive directions nearly independent. The default
    random,     ///< independent, uniform on the sphere
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
    /// @param batch points of the first Fibonacci batch, >= 1. Points drawn from a batch without replacement repel each
    ///        other: their mean scalar product is -1/(size - 1). Power that is scattered several times within one batch
    ///        would be sent back too often (batches of 32: 15 % too little through a slab of optical thickness 5,
    ///        however many sweeps), so batches must outgrow the number of sweeps that power stays in the volume.
    DirectionSequence(DirectionSet set, int batch, std::uint64_t seed);
    Vec3 next();

  private:
    void refill();

    DirectionSet set_;
    std::size_t batch_;
    std::vector<Vec3> shuffled_;
    std::size_t used_ = 0, drawn_ = 0;
    std::uint64_t step_ = 0;
    std::mt19937_64 random_;
};

}  // namespace raysweep
