// Voxels to rays, from beam to beam.
//
// Holds      the beam buffer of voxels: of each pipeline the last beam's interpolated offers.
// Per cycle  in: offers interpolated along u; out: offers interpolated at the rays that end here, a voxel back along u
//            and v.
// Latency    one cycle. Neighbour: the beam before, from the pipeline before.
#pragma once

#include "cube4/ring.h"

namespace raysweep::cube4 {

template <class Arithmetic>
class OfferAlong {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    explicit OfferAlong(const StageShape& shape)
        : offers(std::size_t(shape.pipelines)), shape_(shape), before_(offers.size()), buffer_(shape) {}

    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, Lanes<Offer<Word>>& in, Counters& counters) {
        out = beam;
        if (!beam) return;
        if (!shape_.linear) {
            std::swap(offers, in);
            return;
        }
        buffer_.exchange(beam, in, before_, shape_.offerWords, counters);
        const Between<Weight>& v = beam.slice->endingInRow(beam.row);
        for (std::size_t lane = 0; lane < offers.size(); ++lane)
            offers[lane] = {arithmetic.mix(v, before_[lane].part, in[lane].part),
                            arithmetic.mix(v, before_[lane].given, in[lane].given)};
    }

    std::size_t bufferWords() const { return shape_.linear ? buffer_.wordsPerPipeline(shape_.offerWords) : 0; }

    Beam<Weight> out;
    Lanes<Offer<Word>> offers;

  private:
    StageShape shape_;
    Lanes<Offer<Word>> before_;
    BeamBuffer<Offer<Word>, Weight> buffer_;
};

}  // namespace raysweep::cube4
