// Router of rays that come from a point: takes each finished ray to the pipeline that will meet it in the next slice.
//
// Holds      the rays that are under way, a stage for each pipeline that they may have to move on, with two places in
//            each pipeline; and in each pipeline a short queue of rays to be written.
// Per cycle  in: finished rays with their ways; out: the first ray of each queue.
// Latency    as many cycles as the longest way, and the time in the queue. Neighbour: each stage moves each ray one
//            pipeline on or back, or keeps it.
//
// Rays that diverge spread a partial beam of p voxels over up to p + 2: the first and the last of its rays may belong
// to one pipeline, which is why there are two places. They never are three: of neighbours none overtakes the other.
// A buffer takes one ray in a cycle; the other waits. A queue that might run over stops the machine for a cycle.
#pragma once

#include "cube4/finished_ray.h"

#include <array>
#include <cstdlib>
#include <deque>

namespace raysweep::cube4 {

template <class Arithmetic>
class DivergingRouter {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    static constexpr int kLongest = 5;  ///< slopes up to two voxels in a slice
    static constexpr std::size_t kQueue = 3;

    explicit DivergingRouter(const StageShape& shape)
        : words_(std::uint64_t(shape.rayWords)),
          stages_(kLongest, Stage{{}, Lanes<Places>(std::size_t(shape.pipelines))}),
          moved_(std::size_t(shape.pipelines)),
          queues_(std::size_t(shape.pipelines)) {}

    /// Writes the first ray of each queue. Call it first in a cycle.
    void write(RayBuffer<Word>& buffer, Counters& counters) {
        std::uint64_t oldest = entered_;
        for (std::size_t lane = 0; lane < queues_.size(); ++lane) {
            std::deque<Waiting>& queue = queues_[lane];
            if (queue.empty()) continue;
            buffer.write(lane, queue.front().ray, counters);
            queue.pop_front();
            if (!queue.empty()) oldest = std::min(oldest, queue.front().beam);
        }
        out_ = {};
        if (beams_.empty() || entered_ - beams_.size() >= oldest) return;
        out_ = beams_.front();
        beams_.pop_front();
    }

    /// A queue may not have room for what comes: nothing must move in this cycle.
    bool isFull() const {
        for (const std::deque<Waiting>& queue : queues_)
            if (queue.size() + 2 > kQueue) return true;
        return false;
    }

    void tick(const Beam<Weight>& beam, const Lanes<FinishedRay<Word>>& in, Counters& counters) {
        enqueue(stages_.back(), counters);
        for (std::size_t i = kLongest; i-- > 0;) {
            Stage& stage = stages_[i];
            stage.beam = i == 0 ? beam : stages_[i - 1].beam;
            if (!stage.beam) continue;
            for (Places& places : moved_) places.count = 0;
            for (std::size_t lane = 0; lane < moved_.size(); ++lane) {
                if (i == 0 && in[lane].slot >= 0) move(in[lane], lane, 0, counters);
                if (i == 0) continue;
                const Places& places = stages_[i - 1].rays[lane];
                for (std::size_t n = 0; n < places.count; ++n) move(places.rays[n], lane, int(i), counters);
            }
            std::swap(stage.rays, moved_);
        }
    }

    /// The last partial beam all of whose rays are written; a bubble unless it was in this cycle.
    const Beam<Weight>& out() const { return out_; }

    /// Words of rays in each pipeline's queue and second places.
    std::size_t bufferWords() const { return (kQueue + kLongest) * std::size_t(words_); }

  private:
    struct Places {
        std::array<FinishedRay<Word>, 2> rays;
        std::size_t count = 0;
    };
    struct Stage {
        Beam<Weight> beam;
        Lanes<Places> rays;
    };
    struct Waiting {
        FinishedRay<Word> ray;
        std::uint64_t beam;  ///< number of its partial beam
    };

    void move(const FinishedRay<Word>& ray, std::size_t lane, int stage, Counters& counters) {
        const std::size_t p = moved_.size();
        if (stage < std::abs(ray.hops)) {
            const bool on = ray.hops > 0;
            lane = on ? (lane + 1 == p ? 0 : lane + 1) : (lane == 0 ? p - 1 : lane - 1);
            if (p > 1) (on ? counters.wordsOn : counters.wordsBack) += words_;
        }
        Places& places = moved_[lane];
        counters.meetings += places.count == 1;
        if (places.count == places.rays.size())
            ++counters.conflicts;
        else
            places.rays[places.count++] = ray;
    }

    void enqueue(Stage& stage, Counters& counters) {
        if (!stage.beam) return;
        for (std::size_t lane = 0; lane < queues_.size(); ++lane) {
            const Places& places = stage.rays[lane];
            for (std::size_t n = 0; n < places.count; ++n) queues_[lane].push_back({places.rays[n], entered_});
            counters.queued = std::max(counters.queued, std::uint64_t(queues_[lane].size()));
        }
        beams_.push_back(stage.beam);
        ++entered_;
    }

    std::uint64_t words_;
    std::vector<Stage> stages_;
    Lanes<Places> moved_;
    std::vector<std::deque<Waiting>> queues_;
    std::deque<Beam<Weight>> beams_;  ///< whose rays wait
    std::uint64_t entered_ = 0;       ///< partial beams that came to the queues
    Beam<Weight> out_;
};

}  // namespace raysweep::cube4
