// Compositing, front to back.
//
// Holds      nothing.
// Per cycle  in: rays, and what the samples that they meet have for them; out: changed rays and where they belong. Rays
//            that leave the volume go to the base plane.
// Latency    one cycle.
//
//     C += T α S,    T -= T α
#pragma once

#include "cube4/finished_ray.h"

namespace raysweep::cube4 {

template <class Arithmetic>
class Composite {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    explicit Composite(const StageShape& shape) : rays(std::size_t(shape.pipelines)) {}

    /// @param leaving takes the rays that leave: value C, weight T
    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, const Lanes<Ray<Word>>& in,
              const Lanes<Offer<Word>>& shaded, const Traversal& traversal, const RayBuffer<Word>& buffer,
              RayPlane<Word>& leaving) {
        out = beam;
        if (!beam) return;
        finishRays(beam, traversal, buffer, rays, leaving, [&](std::size_t lane) {
            const Ray<Word>& ray = in[lane];
            return Ray<Word>{arithmetic.add(ray.value, arithmetic.partOf(shaded[lane].given, ray.weight)),
                             arithmetic.subtract(ray.weight, arithmetic.partOf(ray.weight, shaded[lane].part))};
        });
    }

    Beam<Weight> out;
    Lanes<FinishedRay<Word>> rays;
};

}  // namespace raysweep::cube4
