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
#include "cube4/ray_buffer.h"

namespace raysweep::cube4 {

/// A ray on its way back to the compositing buffer.
template <class Word>
struct FinishedRay {
    Ray<Word> ray;
    std::int32_t slot = -1;  ///< address in the buffer; -1: none, it has left
};

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
        const SliceSetup<Weight>& slice = *beam.slice;
        const int reach = traversal.reach, v = beam.row - reach;
        const int lastU = traversal.size.x - 1 - reach, lastV = traversal.size.y - 1 - reach;
        for (FinishedRay<Word>& ray : rays) ray.slot = -1;
        if (v < 0) return;
        const bool leavesRow = slice.last || v + slice.toV < 0 || v + slice.toV > lastV;
        const auto address = buffer.addressOf(v, slice.shiftU, slice.shiftV);
        forEachLane(beam, int(rays.size()), traversal.size.x, [&](std::size_t lane, int at) {
            const int u = at - reach;
            if (u < 0) return;
            const Ray<Word> ray = updated(arithmetic, in[lane].ending, offers[lane]);
            if (leavesRow || u + slice.toU < 0 || u + slice.toU > lastU)
                leaving.at(u - slice.shiftU, v - slice.shiftV) = ray;
            else
                rays[lane] = {ray, address.slotOf(u)};
        });
    }

    Beam<Weight> out;
    Lanes<FinishedRay<Word>> rays;

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
