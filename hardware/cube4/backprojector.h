/// The reverse path: one pass of a front of parallel rays through the volume (paper, section 4). The same pipelines
/// project, backproject and illuminate.
///
///     sequencer -> voxels read -> rays read -> ray_across -> ray_along -> exchange -> voxels written
///                                                                           |
///                  rays written <- router <- ray_update <- offer_along <- offer_across
///
/// Each of these is a stage: it sees the registers of the one before it, changes its own, once in a cycle. Rays are
/// resampled to the voxels by two stages and a beam buffer; in the same cycles the other two, which rendering uses,
/// resample what voxels have to the rays.
#pragma once

#include "cube4/exchange.h"
#include "cube4/ray_buffer.h"
#include "cube4/trace.h"
#include "cube4/traversal.h"
#include "cube4/voxel_memory.h"

#include <cstddef>
#include <vector>

namespace raysweep::cube4 {

struct PassOptions {
    /// Voxels and rays have ports of their own. Without, they share one, and what overlaps here follows each other.
    bool overlap = true;
    Trace* trace = nullptr;  ///< null: none
};

/// What a pass needs besides voxels.
template <class Arithmetic>
struct PassInput {
    const Traversal& traversal;
    const std::vector<SliceSetup<typename Arithmetic::Weight>>& slices;
    const ExchangeSetup<typename Arithmetic::Word>& setup;
    const RayPlane<typename Arithmetic::Word>& entering;
};

/// What it leaves besides voxels.
template <class Word>
struct PassResult {
    RayPlane<Word> leaving;  ///< rays as they leave the volume
    std::uint64_t raysEntered = 0;
    Word largestRay{};  ///< largest value that a ray has had anywhere
    Counters counters;
    std::size_t rayWords = 0;     ///< of the compositing buffer, in each pipeline
    std::size_t bufferWords = 0;  ///< of beam buffers, in each pipeline
};

/// @throw Error if a memory module was used twice in a cycle, or a ray was read before it was back
void requireNoConflicts(const Counters& counters);

/// Runs the clock until all voxels and rays are back.
/// @throw Error if a memory module was used twice in a cycle
template <class Arithmetic>
PassResult<typename Arithmetic::Word> runPass(const Arithmetic& arithmetic,
                                              VoxelMemory<typename Arithmetic::Word>& memory,
                                              const PassInput<Arithmetic>& input, int pipelines,
                                              const PassOptions& options = {});

}  // namespace raysweep::cube4
