/// A solution on voxels twice as long, and what it does for the fine one.
///
/// A solution that begins in the dark has less power under way in its first sweeps than in later ones, and what is
/// still under way after the last has to be swept out. Both give a few directions another weight than the others, and
/// that, not the number of directions, is most of the error after some dozens of sweeps. With a coarse solution of the
/// same scene the fine one begins as if it had been going on for ever: every voxel holds the unshot power of which a
/// sweep shoots just as much as arrives. When it ends, what is under way differs from that by little, and the
/// difference is settled on the coarse level.
#pragma once

#include "raysweep/illuminate/state.h"

#include <cstdint>
#include <vector>

namespace raysweep {

/// Low corners of the bricks that a coarse level of `fine` has, in the order of layouts.
std::vector<Index3> coarseOrigins(const BrickLayout& fine);

class CoarseLevel {
  public:
    /// Averages the medium and adds up the sources of `fine`, which has no surfaces and is not periodic.
    /// @param coarse coarseOrigins of its layout
    CoarseLevel(const SolverState& fine, std::vector<Index3> coarse);

    SolverState state;

    /// After a solution of `state`: gives `fine` the unshot power of which the part `shot` (on average over directions)
    /// is what arrives in a sweep. Remembers how much that was.
    void start(SolverState& fine, double shot);

    /// After the sweeps of `fine`: makes `state` one in which the unshot power that `fine` has gained since the start
    /// (`sign` 1) or lost (-1) is to be shot, and nothing else.
    void takeChange(const SolverState& fine, int sign);
    /// Remembers what has become of it.
    void rememberChange(int sign);
    /// Gives `fine` what has become of the change: deposits, what is still unshot here, and what has escaped. No power
    /// is lost by it: what would have to be less than nothing in a voxel is taken from all of them.
    void settle(SolverState& fine) const;

    /// A sweep of this level, in sweeps of `fine`.
    double sweepCost(const SolverState& fine) const {
        return double(state.medium.volume.layout.brickCount()) / double(fine.medium.volume.layout.brickCount());
    }

  private:
    /// Calls `visit(i, j)` for voxel i of fine brick `b` and voxel j of the coarse brick that holds it.
    template <class Visit>
    void forEachVoxel(const SolverState& fine, std::size_t b, const Visit& visit) const;

    /// Calls `visit(voxels, j)` for the eight voxels of fine brick `b`, in the order (x, y, z), that are voxel j of the
    /// coarse brick.
    template <class Visit>
    void forEachCoarseVoxel(const SolverState& fine, std::size_t b, const Visit& visit) const;

    /// @return power that `fine` then holds too much, since nothing can be below 0
    double settleBrick(SolverState& fine, int c, std::size_t b) const;

    std::vector<std::uint32_t> parents_;  ///< coarse brick of each fine one
    BrickField started_[kMaxChannels];    ///< unshot power that `fine` had at the start
    // What became of the change, of either sign:
    BrickField changeDeposit_[kMaxChannels], changeUnshot_[kMaxChannels];
    ChannelPower escaped_;
};

}  // namespace raysweep
