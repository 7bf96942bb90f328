// Sequencer: the clock's program.
//
// Holds      the number of the next partial beam, and how far finished rays are back in the compositing buffer.
// Per cycle  in: whether the last beam's rays are written; out: the control word of a partial beam, or a bubble.
// Latency    one cycle.
//
// Beams follow each other along u, then v, then k, as Cube-4 reads them (paper, section 4). A beam is issued every
// `interval` cycles: 1 where voxels are read only; 2 where they are written back, since a memory module is read or
// written in a cycle; 4 where rays go through the same port. It waits for rays that it needs and that are still under
// way from the slice before: a stall.
#pragma once

#include "cube4/counters.h"
#include "cube4/traversal.h"

namespace raysweep::cube4 {

/// Which rays a beam of voxels needs.
struct RayNeed {
    int back = 0;   ///< those that many voxels before it along u and v,
    int delay = 0;  ///< in the slice that many before
};

template <class Weight>
class Sequencer {
  public:
    Sequencer(const Traversal& traversal, const std::vector<SliceSetup<Weight>>& slices, int pipelines, int interval,
              const RayNeed& need = {})
        : slices_(slices),
          size_(traversal.size),
          reach_(traversal.reach),
          need_(need),
          pipelines_(pipelines),
          parts_((traversal.size.x + pipelines - 1) / pipelines),
          interval_(interval) {}

    /// @param back the last partial beam whose rays are back, in the order of issue
    void tick(const Beam<Weight>& back, Counters& counters) {
        note(back);
        out = {};
        if (wait_ > 0) {
            --wait_;
            return;
        }
        if (done()) return;
        if (!raysAreBack()) {
            ++counters.stalls;
            // The next chance to read is an interval later: memory modules have their fixed cycles for reading.
            wait_ = interval_ - 1;
            counters.stalls += std::uint64_t(wait_);
            return;
        }
        const SliceSetup<Weight>& slice = slices_[std::size_t(slice_)];
        out = {&slice, row_, part_, (part_ * pipelines_ + row_ + slice_) % pipelines_};
        ++counters.beams;
        wait_ = interval_ - 1;
        advance();
    }

    /// That the rays of a partial beam are back. All that happens in a cycle in which the machine is stopped.
    void note(const Beam<Weight>& back) {
        if (!back || back.part != parts_ - 1) return;
        backSlice_ = back.slice->number;
        backRow_ = back.row;
    }

    bool done() const { return slice_ == size_.z; }
    int parts() const { return parts_; }

    Beam<Weight> out;

  private:
    void advance() {
        if (++part_ < parts_) return;
        part_ = 0;
        if (++row_ < size_.y) return;
        row_ = 0;
        ++slice_;
    }

    /// The rays of this row were finished in the slice before, `reach` rows later than where they were.
    bool raysAreBack() const {
        const int slice = slice_ - need_.delay;
        if (slice <= 0) return true;
        if (slices_[std::size_t(slice)].diverges()) return divergingAreBack(slices_[std::size_t(slice)]);
        const int was = row_ - need_.back - slices_[std::size_t(slice)].fromV;
        if (was < 0 || was >= size_.y - reach_) return true;  // they have just come in from the side
        return isBack(slice - 1, was + reach_);
    }

    bool divergingAreBack(const SliceSetup<Weight>& slice) const {
        const int row = row_ - need_.back;
        if (row < 0) return true;
        const Place<Weight>& place = slice.placesV[std::size_t(row)];
        return !place.hasRay || place.from < 0 || isBack(slice.number - 1, place.from + reach_);
    }

    bool isBack(int slice, int row) const { return backSlice_ > slice || (backSlice_ == slice && backRow_ >= row); }

    const std::vector<SliceSetup<Weight>>& slices_;
    Index3 size_;
    int reach_;
    RayNeed need_;
    int pipelines_, parts_, interval_;
    int slice_ = 0, row_ = 0, part_ = 0, wait_ = 0;
    int backSlice_ = -1, backRow_ = -1;
};

}  // namespace raysweep::cube4
