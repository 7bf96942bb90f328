// Rays to voxels, from beam to beam.
//
// Holds      the beam buffer of rays: of each pipeline the last beam's interpolated rays and those that end.
// Per cycle  in: rays interpolated along u; out: rays interpolated at the voxels, and the rays that end there.
// Latency    one cycle. Neighbour: the beam before, from the pipeline before.
#pragma once

#include "cube4/ray_across.h"

namespace raysweep::cube4 {

template <class Arithmetic>
class RayAlong {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;
    using Rays = typename RayAcross<Arithmetic>::Rays;

    explicit RayAlong(const StageShape& shape)
        : rays(std::size_t(shape.pipelines)), shape_(shape), before_(rays.size()), buffer_(shape) {}

    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, Lanes<Rays>& in, Counters& counters) {
        out = beam;
        if (!beam) return;
        if (!shape_.linear) {
            std::swap(rays, in);
            return;
        }
        buffer_.exchange(beam, in, before_, 2 * shape_.rayWords, counters);
        const Between<Weight>& v = beam.slice->atRow(beam.row);
        for (std::size_t lane = 0; lane < rays.size(); ++lane) {
            const Ray<Word>&own = in[lane].across, &before = before_[lane].across;
            rays[lane].across = {arithmetic.mix(v, own.value, before.value),
                                 arithmetic.mix(v, own.weight, before.weight)};
            rays[lane].ending = before_[lane].ending;
        }
    }

    std::size_t bufferWords() const { return shape_.linear ? buffer_.wordsPerPipeline(2 * shape_.rayWords) : 0; }

    Beam<Weight> out;
    Lanes<Rays> rays;

  private:
    StageShape shape_;
    Lanes<Rays> before_;
    BeamBuffer<Rays, Weight> buffer_;
};

}  // namespace raysweep::cube4
