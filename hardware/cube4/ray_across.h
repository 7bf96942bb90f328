// Rays to voxels, along the beam.
//
// Holds      the last partial beam's rays, for the pipeline on whose right the beam goes on.
// Per cycle  in: the rays above and below which voxels lie; out: rays interpolated along u at the voxels, and beside
//            each the ray that is one voxel back along u, which its voxels finish (ray_update.h).
// Latency    one cycle. Neighbour: a ray from the pipeline before.
//
// A voxel x is above the ray of position x - 1 and below that of position x: it gets their parts `high` and `low`.
#pragma once

#include "cube4/ring.h"

namespace raysweep::cube4 {

template <class Arithmetic>
class RayAcross {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    /// Rays at voxels, and the rays that end there.
    struct Rays {
        Ray<Word> across, ending;
    };

    explicit RayAcross(const StageShape& shape)
        : rays(std::size_t(shape.pipelines)), shape_(shape), left_(rays.size()), neighbour_(shape.pipelines) {}

    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, const Lanes<Ray<Word>>& in, Counters& counters) {
        out = beam;
        if (!beam) return;
        if (!shape_.linear) {
            for (std::size_t lane = 0; lane < rays.size(); ++lane) rays[lane] = {in[lane], in[lane]};
            return;
        }
        neighbour_.shift(beam, in, left_, shape_.rayWords, counters);
        if (beam.slice->diverges()) {
            const auto& places = beam.slice->placesU;
            forEachLane(beam, shape_.pipelines, int(places.size()), [&](std::size_t lane, int u) {
                interpolate(arithmetic, places[std::size_t(u)].atVoxel, in[lane], lane);
            });
            return;
        }
        for (std::size_t lane = 0; lane < rays.size(); ++lane) interpolate(arithmetic, beam.slice->u, in[lane], lane);
    }

    Beam<Weight> out;
    Lanes<Rays> rays;

  private:
    void interpolate(const Arithmetic& arithmetic, const Between<Weight>& u, const Ray<Word>& own, std::size_t lane) {
        const Ray<Word>& left = left_[lane];
        // The ray at the voxel has the weight that the voxel has for the ray: the lower of its two.
        rays[lane].across = {arithmetic.mix(u, own.value, left.value), arithmetic.mix(u, own.weight, left.weight)};
        rays[lane].ending = left;
    }

    StageShape shape_;
    Lanes<Ray<Word>> left_;
    LeftNeighbour<Ray<Word>, Weight> neighbour_;
};

}  // namespace raysweep::cube4
