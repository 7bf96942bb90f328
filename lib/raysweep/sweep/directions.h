/// Directions in which a solution is swept.
#pragma once

#include "raysweep/core/types.h"

#include <cstdint>
#include <deque>
#include <functional>
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
    struct Options {
        DirectionSet set = DirectionSet::fibonacci;
        /// Points of the first Fibonacci batch, or about so many if `total` is known, >= 1. Points drawn from a batch
        /// without replacement repel each other: their mean scalar product is -1/(size - 1). Power that is scattered
        /// several times within one batch would be sent back too often (batches of 32: 15 % too little through a slab
        /// of optical thickness 5, however many sweeps), so batches must outgrow the number of sweeps that power stays
        /// in the volume.
        int batch = 32;
        std::uint64_t seed = 1;
        int groupSize = 1;  ///< directions that are to come in a group, >= 1
        int total = 0;      ///< directions that will be asked for, for a batch to end there; 0: not known
    };

    /// @param classOf number of the class of a direction, in [0, kDirectionClasses); a group is of one class
    explicit DirectionSequence(const Options& options, std::function<int(const Vec3&)> classOf = {});
    /// Directions of one class: up to `groupSize` and up to `most`. Those left over come next.
    std::vector<Vec3> nextGroup(int most);
    int groupSize() const { return options_.groupSize; }
    /// Directions of the batch, and those that are left of it: 0 when it is complete. Sets without batches are one that
    /// has no end.
    int batch() const { return batch_; }
    int left() const { return left_; }

  private:
    Vec3 nextOfRecurrence();
    std::size_t firstBatch() const;
    std::size_t nextBatch() const;
    void refill();
    int classOf(const Vec3& direction) const;

    Options options_;
    std::function<int(const Vec3&)> classOf_;
    std::deque<std::vector<Vec3>> groups_;
    std::size_t drawn_ = 0;
    int batch_ = 0, left_ = 0;
    std::uint64_t step_ = 0;
    std::mt19937_64 random_;
};

}  // namespace raysweep
