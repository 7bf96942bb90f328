// Classification and shading.
//
// Holds      the table of opacities by extinction (fixed point).
// Per cycle  in: a sample, and with shading its neighbours; out: its opacity α, and what shines through it, α S cos.
// Latency    one cycle.
//
// S is the source radiance of a lit voxel, α = 1 - exp(-σ ds). With shading S is multiplied by max(0, d·∇σ/|∇σ|), d the
// direction of view: the paper's cosine (section 2.3). Where σ is flat the factor is 1.
#pragma once

#include "cube4/gradient.h"

#include "raysweep/core/types.h"

#include <algorithm>
#include <cmath>

namespace raysweep::cube4 {

template <class Word>
struct ShadeSetup {
    double depth = 1;      ///< optical depth of a sample of scalar 1; where rays diverge, along the longest
    bool lambert = false;  ///< with shading
    Vec3 view{0, 0, 1};    ///< d as a covector along u, v and k: its product with ∂/∂(u,v,k) is that with ∇
    Matrix3 metric;        ///< of gradients along u, v and k: |∇σ|² = g metric gᵀ
    // Where rays come from a point: of the way d of a ray in a slice the length is sqrt(d lengths dᵀ) of the longest's.
    Matrix3 lengths;
    int reach = 1;              ///< voxels from where a ray is to where it ends
    std::vector<Word> opacity;  ///< fixed point: by the leading bits of a scalar
    int tableShift = 0;
};

template <class Arithmetic>
class Shade {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    Shade(const StageShape& shape, const ShadeSetup<Word>& setup)
        : shaded(std::size_t(shape.pipelines)), setup_(setup) {}

    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, const Lanes<Offer<Word>>& samples) {
        out = beam;
        if (!beam) return;
        if (beam.slice->diverges()) {
            shadeDiverging(arithmetic, beam, samples);
            return;
        }
        for (std::size_t lane = 0; lane < shaded.size(); ++lane) shaded[lane] = classified(arithmetic, samples[lane]);
    }

    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, const Lanes<SampleNeighbours<Word>>& neighbours) {
        out = beam;
        if (!beam) return;
        for (std::size_t lane = 0; lane < shaded.size(); ++lane) {
            shaded[lane] = classified(arithmetic, neighbours[lane].middle);
            shaded[lane].given =
                arithmetic.partOf(shaded[lane].given, arithmetic.partWord(cosine(*beam.slice, neighbours[lane])));
        }
    }

    Beam<Weight> out;
    Lanes<Offer<Word>> shaded;

  private:
    /// Each ray has its own length in a slice: the sample's scalar is multiplied by it before the table is looked up.
    void shadeDiverging(const Arithmetic& arithmetic, const Beam<Weight>& beam, const Lanes<Offer<Word>>& samples) {
        const auto &placesU = beam.slice->placesU, &placesV = beam.slice->placesV;
        const int row = beam.row - setup_.reach;
        if (row < 0) return;
        forEachLane(beam, int(shaded.size()), int(placesU.size()), [&](std::size_t lane, int at) {
            const int column = at - setup_.reach;
            if (column < 0) return;
            const Vec3 way(placesU[std::size_t(column)].slope, placesV[std::size_t(row)].slope, 1);
            Offer<Word> sample = samples[lane];
            sample.part = arithmetic.partOf(
                sample.part, arithmetic.partWord(std::min(1.0, std::sqrt((way * setup_.lengths).dot(way)))));
            shaded[lane] = classified(arithmetic, sample);
        });
    }

    Offer<Word> classified(const Arithmetic& arithmetic, const Offer<Word>& sample) const {
        if constexpr (Arithmetic::kExact) {
            const float opacity = -std::expm1(-float(setup_.depth) * sample.part);
            return {opacity, opacity * sample.given};
        } else {
            const Word opacity = setup_.opacity[std::size_t(sample.part >> setup_.tableShift)];
            return {opacity, arithmetic.partOf(sample.given, opacity)};
        }
    }

    /// As a table for the gradient gives it.
    double cosine(const SliceSetup<Weight>& slice, const SampleNeighbours<Word>& sample) const {
        const auto half = [&](std::size_t axis) {
            return 0.5 * (double(sample.above[axis]) - double(sample.below[axis]));
        };
        Vec3 g(half(0), half(1), half(2));
        // The samples of the slices beside it are not straight above each other.
        g.z -= 0.5 * (g.x * slice.slantU + g.y * slice.slantV);
        const double length = std::sqrt((g * setup_.metric).dot(g));
        return length > 0 ? std::clamp(g.dot(setup_.view) / length, 0.0, 1.0) : 1;
    }

    const ShadeSetup<Word>& setup_;
};

}  // namespace raysweep::cube4
