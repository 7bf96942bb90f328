// Router: takes finished rays to the pipelines that will meet them in the next slice.
//
// Holds      the rays that are under way, a stage for each pipeline that they may have to move on.
// Per cycle  in: finished rays; out: rays at their pipelines.
// Latency    as many cycles as the longest way. Neighbour: each stage moves its rays one pipeline on or back, or keeps
//            them; all rays of a slice go the same way.
//
// A ray at voxel (u,v) is in pipeline (u + v + k) mod p. From slice to slice u and v change by -1, 0 or 1, so it has to
// move by 1 and what they change by; a linear ray ends a voxel further along u and v, which is two pipelines less.
#pragma once

#include "cube4/finished_ray.h"

#include <cstdlib>

namespace raysweep::cube4 {

template <class Arithmetic>
class Router {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    static constexpr int kLongest = 3;

    explicit Router(const StageShape& shape)
        : words_(std::size_t(shape.rayWords)),
          stages_(kLongest, Stage{{}, Lanes<FinishedRay<Word>>(std::size_t(shape.pipelines))}),
          moved_(std::size_t(shape.pipelines)) {}

    void tick(const Beam<Weight>& beam, Lanes<FinishedRay<Word>>& in, Counters& counters) {
        for (std::size_t i = kLongest; i-- > 0;) {
            Stage& stage = stages_[i];
            const Beam<Weight>& from = i == 0 ? beam : stages_[i - 1].beam;
            Lanes<FinishedRay<Word>>& rays = i == 0 ? in : stages_[i - 1].rays;
            stage.beam = from;
            if (!from) continue;
            std::swap(stage.rays, rays);
            const int hops = from.slice->hops;
            if (int(i) < std::abs(hops)) move(stage.rays, hops > 0, counters);
        }
    }

    const Beam<Weight>& out() const { return stages_.back().beam; }
    const Lanes<FinishedRay<Word>>& rays() const { return stages_.back().rays; }

  private:
    struct Stage {
        Beam<Weight> beam;
        Lanes<FinishedRay<Word>> rays;
    };

    void move(Lanes<FinishedRay<Word>>& rays, bool on, Counters& counters) {
        const std::size_t p = rays.size();
        if (on) {
            std::copy(rays.begin(), rays.end() - 1, moved_.begin() + 1);
            moved_[0] = rays[p - 1];
            counters.wordsOn += handedOn(words_, p);
        } else {
            std::copy(rays.begin() + 1, rays.end(), moved_.begin());
            moved_[p - 1] = rays[0];
            counters.wordsBack += handedOn(words_, p);
        }
        std::swap(rays, moved_);
    }

    std::size_t words_;
    std::vector<Stage> stages_;
    Lanes<FinishedRay<Word>> moved_;
};

}  // namespace raysweep::cube4
