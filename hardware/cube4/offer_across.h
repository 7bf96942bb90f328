// Voxels to rays, along the beam.
//
// Holds      the last partial beam's offers, for the pipeline on whose right the beam goes on.
// Per cycle  in: what voxels have for rays; out: that interpolated along u at the rays one voxel back.
// Latency    one cycle. Neighbour: an offer from the pipeline before.
#pragma once

#include "cube4/ring.h"

namespace raysweep::cube4 {

template <class Arithmetic>
class OfferAcross {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    explicit OfferAcross(const StageShape& shape)
        : offers(std::size_t(shape.pipelines)), shape_(shape), left_(offers.size()), neighbour_(shape.pipelines) {}

    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, Lanes<Offer<Word>>& in, Counters& counters) {
        out = beam;
        if (!beam) return;
        if (!shape_.linear) {
            std::swap(offers, in);
            return;
        }
        neighbour_.shift(beam, in, left_, shape_.offerWords, counters);
        if (beam.slice->diverges()) {
            const auto& places = beam.slice->placesU;
            forEachLane(beam, shape_.pipelines, int(places.size()), [&](std::size_t lane, int u) {
                interpolate(arithmetic, places[std::size_t(u)].ending, in[lane], lane);
            });
            return;
        }
        for (std::size_t lane = 0; lane < offers.size(); ++lane) interpolate(arithmetic, beam.slice->u, in[lane], lane);
    }

    Beam<Weight> out;
    Lanes<Offer<Word>> offers;

  private:
    void interpolate(const Arithmetic& arithmetic, const Between<Weight>& u, const Offer<Word>& own, std::size_t lane) {
        offers[lane] = {arithmetic.mix(u, left_[lane].part, own.part), arithmetic.mix(u, left_[lane].given, own.given)};
    }

    StageShape shape_;
    Lanes<Offer<Word>> left_;
    LeftNeighbour<Offer<Word>, Weight> neighbour_;
};

}  // namespace raysweep::cube4
