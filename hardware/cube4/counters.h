/// What the machine counts while it runs. Nothing here is computed from sizes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace raysweep::cube4 {

struct Counters {
    std::uint64_t cycles = 0;
    std::uint64_t stalls = 0;       ///< cycles in which a beam could not be issued because its rays were not back yet
    std::uint64_t beams = 0;        ///< partial beams issued
    std::uint64_t conflicts = 0;    ///< accesses of a memory module beyond one in a cycle
    std::uint64_t saturations = 0;  ///< sums of powers that did not fit their words, and became the largest that does
    std::uint64_t hazards = 0;      ///< rays that were read and were not those that were wanted
    std::uint64_t voxelReads = 0, voxelWrites = 0;
    std::uint64_t rayReads = 0, rayWrites = 0;
    std::uint64_t wordsOn = 0;    ///< words handed to the next pipeline of the ring, in the order of the pass
    std::uint64_t wordsBack = 0;  ///< to the one before

    // Where rays come from a point.
    std::uint64_t meetings = 0;     ///< rays that found another one in the place that they moved to
    std::uint64_t queued = 0;       ///< the most rays that waited in a pipeline to be written
    std::uint64_t boundCycles = 0;  ///< cycles, of `cycles`, in which rays were split or merged
    std::uint64_t boundRays = 0;    ///< the most rays of a front at a bound

    Counters& operator+=(const Counters& o) {
        cycles += o.cycles, stalls += o.stalls, beams += o.beams, conflicts += o.conflicts;
        saturations += o.saturations, hazards += o.hazards;
        voxelReads += o.voxelReads, voxelWrites += o.voxelWrites, rayReads += o.rayReads, rayWrites += o.rayWrites;
        wordsOn += o.wordsOn, wordsBack += o.wordsBack;
        meetings += o.meetings, queued = std::max(queued, o.queued), boundCycles += o.boundCycles;
        boundRays = std::max(boundRays, o.boundRays);
        return *this;
    }
};

/// Words of all pipelines to their neighbours, so many from each. A ring of one has none.
inline std::uint64_t handedOn(std::size_t words, std::size_t pipelines) {
    return pipelines > 1 ? std::uint64_t(words) * pipelines : 0;
}

}  // namespace raysweep::cube4
