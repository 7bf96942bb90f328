// Ray update: a ray and what its voxels have for it.
//
// Holds      nothing.
// Per cycle  in: rays that end here, and offers interpolated at them; out: changed rays and where they belong. Rays
//            that leave the volume go to the output.
// Latency    one cycle.
//
//     illuminating   e += out - e α        projecting   sum += x, weight += 1        backprojecting   unchanged
#pragma once

#include "cube4/exchange.h"
#include "cube4/finished_ray.h"

#include <algorithm>

namespace raysweep::cube4 {

template <class Arithmetic>
class RayUpdate {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    RayUpdate(int pipelines, Pass pass) : rays(std::size_t(pipelines)), pass_(pass) {}

    using Rays = typename RayAcross<Arithmetic>::Rays;

    /// @param leaving takes the rays that leave
    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, const Lanes<Rays>& in,
              const Lanes<Offer<Word>>& offers, const Traversal& traversal, const RayBuffer<Word>& buffer,
              RayPlane<Word>& leaving) {
        out = beam;
        if (!beam) return;
        finishRays(beam, traversal, buffer, rays, leaving, [&](std::size_t lane) {
            const Ray<Word> ray = updated(arithmetic, in[lane].ending, offers[lane]);
            largest = std::max(largest, ray.value);
            return ray;
        });
    }

    Beam<Weight> out;
    Lanes<FinishedRay<Word>> rays;
    Word largest{};  ///< value of a ray so far

  private:
    Ray<Word> updated(const Arithmetic& arithmetic, Ray<Word> ray, const Offer<Word>& offer) const {
        if (pass_ == Pass::illuminate)
            ray.value =
                arithmetic.add(arithmetic.subtract(ray.value, arithmetic.partOf(ray.value, offer.part)), offer.given);
        if (pass_ == Pass::project) {
            ray.value = arithmetic.accumulate(ray.value, offer.given);
            ray.weight = arithmetic.accumulate(ray.weight, offer.part);
        }
        return ray;
    }

    Pass pass_;
};

}  // namespace raysweep::cube4
