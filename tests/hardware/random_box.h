/// A box of random voxels, for the library's sweeps and for the emulator.
#pragma once

#include "cube4/backprojector.h"

#include <random>

#include "raysweep/sweep/sweep.h"

namespace raysweep::test {

/// Bricks of random extinction, albedo, source and unshot power.
class RandomBox {
  public:
    /// @param pad empty voxels around the emulator's: 1 where it resamples linearly
    RandomBox(const Index3& bricks, int pipelines, int pad, cube4::Skew skew = cube4::Skew::diagonal);

    /// One beam through the library's volume. @return what its rays carried
    RaySums sweep(const Vec3& direction, const LatticeOffset& offset, float zeta);
    /// The same through the emulator's.
    cube4::PassResult<float> pass(const Vec3& direction, const LatticeOffset& offset, float zeta,
                                  const cube4::PassOptions& options = {});

    double worstUnshot() const;  ///< largest difference between the two, over the largest value
    double worstDeposit() const;
    Index3 size() const { return layout_.high; }
    cube4::VoxelMemory<float>& memory() { return memory_; }

  private:
    template <class Visit>
    void forEachVoxel(const Visit& visit) const;

    double worst(const BrickField& theirs, float cube4::Voxel<float>::*ours) const;

    BrickLayout layout_;
    int pipelines_, pad_;
    cube4::VoxelMemory<float> memory_;
    BrickField tau_, albedo_, source_, unshot_, deposit_, fresh_;
};

constexpr float kEntering = 0.7f;  ///< power of a ray

}  // namespace raysweep::test
