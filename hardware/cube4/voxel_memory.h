// Voxel memory: p modules, one for each pipeline.
//
// Holds      the voxel (x,y,z) in module (x + y + z) mod p, so that any p voxels in a row along any axis are in p
//            modules (Kaufman's skewed memory). It has one port: it is read or written in a cycle.
// Per cycle  in: a partial beam to read, one to write; out: the voxels that were read.
// Latency    one cycle.
//
// Every access is checked: that pipeline i finds its voxel in module i, and that no module is used twice in a cycle.
#pragma once

#include "cube4/counters.h"
#include "cube4/traversal.h"

#include <algorithm>
#include <cstdint>

namespace raysweep::cube4 {

/// How voxels are spread over modules.
enum class Skew {
    diagonal,  ///< (x + y + z) mod p
    none       ///< z mod p: what a memory without the skew would do, to see it fail
};

template <class Word>
class VoxelMemory {
  public:
    VoxelMemory(const Index3& size, int pipelines, Skew skew = Skew::diagonal)
        : size_(size),
          pipelines_(pipelines),
          skew_(skew),
          voxels_(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z)),
          used_(std::size_t(pipelines), 0) {
        std::vector<std::size_t> held(std::size_t(pipelines), 0);
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) ++held[std::size_t(moduleOf({x, y, z}))];
        fullest_ = *std::max_element(held.begin(), held.end());
    }

    const Index3& size() const { return size_; }
    Voxel<Word>& at(const Index3& voxel) { return voxels_[indexOf(voxel)]; }
    const Voxel<Word>& at(const Index3& voxel) const { return voxels_[indexOf(voxel)]; }
    std::vector<Voxel<Word>>& all() { return voxels_; }
    const std::vector<Voxel<Word>>& all() const { return voxels_; }

    /// Calls `visit(i, voxel)` for the voxels that are at least `pad` away from the memory's faces, x fastest; i counts
    /// them.
    template <class Visit>
    void forEachWithin(int pad, const Visit& visit) {
        walkWithin(*this, pad, visit);
    }
    template <class Visit>
    void forEachWithin(int pad, const Visit& visit) const {
        walkWithin(*this, pad, visit);
    }

    /// That the fullest module holds: the others are as large.
    std::size_t voxelsPerModule() const { return fullest_; }

    template <class Weight>
    void read(const Beam<Weight>& beam, const Traversal& traversal, Lanes<Voxel<Word>>& out, Counters& counters) {
        access(beam, traversal, counters, [&](std::size_t lane, std::size_t index) {
            out[lane] = voxels_[index];
            ++counters.voxelReads;
        });
    }

    template <class Weight>
    void write(const Beam<Weight>& beam, const Traversal& traversal, const Lanes<Voxel<Word>>& in, Counters& counters) {
        access(beam, traversal, counters, [&](std::size_t lane, std::size_t index) {
            voxels_[index] = in[lane];
            ++counters.voxelWrites;
        });
    }

    void beginCycle() { ++cycle_; }

  private:
    template <class Memory, class Visit>
    static void walkWithin(Memory& memory, int pad, const Visit& visit) {
        std::size_t i = 0;
        for (int z = pad; z < memory.size_.z - pad; ++z)
            for (int y = pad; y < memory.size_.y - pad; ++y)
                for (int x = pad; x < memory.size_.x - pad; ++x) visit(i++, memory.at({x, y, z}));
    }

    std::size_t indexOf(const Index3& voxel) const {
        return (std::size_t(voxel.z) * std::size_t(size_.y) + std::size_t(voxel.y)) * std::size_t(size_.x) +
               std::size_t(voxel.x);
    }

    int moduleOf(const Index3& voxel) const {
        return skew_ == Skew::diagonal ? (voxel.x + voxel.y + voxel.z) % pipelines_ : voxel.z % pipelines_;
    }

    /// The module that is wired to the pipeline which is number `lane` in the order of the pass.
    int homeOf(int lane, const Traversal& traversal) const {
        const Index3& origin = traversal.origin;
        const int home = origin.x + origin.y + origin.z + (traversal.descending ? pipelines_ - lane : lane);
        return home % pipelines_;
    }

    template <class Weight>
    int countOf(const Beam<Weight>& beam, const Traversal& traversal) const {
        return std::min(pipelines_, traversal.size.x - beam.part * pipelines_);
    }

    template <class Weight, class Use>
    void access(const Beam<Weight>& beam, const Traversal& traversal, Counters& counters, const Use& use) {
        Index3 voxel;
        voxel[traversal.axisU] = traversal.memoryCoordinate(traversal.axisU, beam.part * pipelines_);
        voxel[traversal.axisV] = traversal.memoryCoordinate(traversal.axisV, beam.row);
        voxel[traversal.major] = traversal.memoryCoordinate(traversal.major, beam.slice->number);
        const int sense = traversal.descending ? -1 : 1;
        Index3 next = voxel;
        next[traversal.axisU] += sense;
        const std::ptrdiff_t first = std::ptrdiff_t(indexOf(voxel));
        const std::ptrdiff_t stride = sense * std::ptrdiff_t(traversal.axisU == 0   ? 1
                                                             : traversal.axisU == 1 ? size_.x
                                                                                    : size_.x * size_.y);
        const int count = countOf(beam, traversal);
        int module = moduleOf(voxel);
        const int moduleStep = skew_ == Skew::diagonal || traversal.axisU == 2 ? sense : 0;
        counters.conflicts += module != homeOf(beam.first, traversal);
        std::size_t lane = std::size_t(beam.first);
        std::ptrdiff_t index = first;
        for (int j = 0; j < count; ++j) {
            std::uint64_t& used = used_[std::size_t(module)];
            counters.conflicts += used == cycle_;
            used = cycle_;
            use(lane, std::size_t(index));
            index += stride;
            lane = lane + 1 == std::size_t(pipelines_) ? 0 : lane + 1;
            module += moduleStep;
            module = module == pipelines_ ? 0 : module < 0 ? pipelines_ - 1 : module;
        }
    }

    Index3 size_;
    int pipelines_;
    Skew skew_;
    std::vector<Voxel<Word>> voxels_;
    std::vector<std::uint64_t> used_;  ///< the last cycle in which a module was used
    std::uint64_t cycle_ = 0;
    std::size_t fullest_ = 0;
};

}  // namespace raysweep::cube4
