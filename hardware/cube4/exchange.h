// Exchange: what a voxel and the ray at it do to each other (Dachille, Mueller and Kaufman 2000, Algorithm 1 and
// section 3).
//
// Holds      the tables of the pass: opacity and the part that is shot, by scalar (fixed point).
// Per cycle  in: voxels, and rays interpolated at them; out: the changed voxels, and what they have for rays.
// Latency    one cycle.
//
//     illuminating     α = 1 - exp(-σ len),  in = e α,  out = U s,  s the part that is shot
//                      D += in,  U += g in - out + source
//                      the ray is offered α and out; 0 and out - in where it is alone with the voxel (nearest)
//     projecting       the ray is offered 1 and x
//     backprojecting   x = clamp(x + λ c / w),  c the corrections of rays, w how much of rays that count is here; in a
//                      pass of several c is added up in `fresh` and w in `deposit`
//
// A voxel with a surface of normal n takes from rays that arrive, ω·n < 0, and shoots s = min(most, 4 part) ω·n into
// those that leave; as printed it takes α |ω·n| and shoots most ω·n.
#pragma once

#include "cube4/ray_across.h"

#include "raysweep/core/types.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace raysweep::cube4 {

enum class Pass { illuminate, project, backproject };

/// Constants of a pass.
template <class Word>
struct ExchangeSetup {
    Pass pass = Pass::illuminate;
    // Illuminating.
    double depth = 1;      ///< optical depth of a voxel of scalar 1 along a ray
    double part = 1;       ///< s is at most part / p times (1 - exp(-τ)) / τ along a ray, p the escape probability,
    double most = 1;       ///< and at most this
    bool printed = false;  ///< surfaces as Algorithm 1 is printed
    double ofSurface = 1;  ///< a surface shoots this times the cosine
    Vec3 travel{0, 0, 1};  ///< direction of travel, world space, unit
    bool inject = false;   ///< sources are added
    bool group = false;    ///< one of several directions that see the same U: changes are added up beside it,
    bool settle = true;    ///< and become part of it in the last one; of corrections likewise
    // Backprojecting.
    bool several = false;  ///< one of several passes whose corrections are added up beside x
    Word relaxation{};     ///< λ
    Ray<Word> bounds{};    ///< least and largest value of a voxel
    // Fixed point: by the leading bits of a scalar.
    std::vector<Word> opacity, shot;
    int tableShift = 0;  ///< bits of a scalar that are left out
};

template <class Arithmetic>
class Exchange {
  public:
    using Word = typename Arithmetic::Word;
    using Weight = typename Arithmetic::Weight;

    using Rays = typename RayAcross<Arithmetic>::Rays;

    Exchange(const StageShape& shape, const ExchangeSetup<Word>& setup)
        : voxels(std::size_t(shape.pipelines)),
          offers(voxels.size()),
          rays(voxels.size()),
          linear_(shape.linear),
          setup_(setup) {}

    void tick(const Arithmetic& arithmetic, const Beam<Weight>& beam, Lanes<Voxel<Word>>& in, Lanes<Rays>& atVoxels) {
        out = beam;
        if (!beam) return;
        std::swap(voxels, in);
        std::swap(rays, atVoxels);
        switch (setup_.pass) {
            case Pass::illuminate:
                for (std::size_t lane = 0; lane < voxels.size(); ++lane)
                    offers[lane] = illuminated(arithmetic, voxels[lane], rays[lane].across.value);
                break;
            case Pass::project:
                for (std::size_t lane = 0; lane < voxels.size(); ++lane)
                    offers[lane] = {voxels[lane].gain, voxels[lane].scalar};
                break;
            case Pass::backproject:
                for (std::size_t lane = 0; lane < voxels.size(); ++lane)
                    correct(arithmetic, voxels[lane], rays[lane].across);
                break;
        }
    }

    Beam<Weight> out;
    Lanes<Voxel<Word>> voxels;
    Lanes<Offer<Word>> offers;
    Lanes<Rays> rays;  ///< as they came

  private:
    /// Opacity, and the part of U that is shot.
    Offer<Word> terms(const Voxel<Word>& voxel) const {
        if constexpr (Arithmetic::kExact) {
            const float depth = float(setup_.depth) * voxel.scalar;
            if (!(depth > 0)) return {0, std::min(float(setup_.part) * voxel.escape, float(setup_.most))};
            const float opacity = -std::expm1(-depth);
            return {opacity, std::min(float(setup_.part) * voxel.escape * (opacity / depth), float(setup_.most))};
        } else {
            const auto entry = std::size_t(voxel.scalar >> setup_.tableShift);
            return {setup_.opacity[entry], setup_.shot[entry]};
        }
    }

    /// The same of a voxel that has a surface: `term`, changed.
    Offer<Word> atSurface(const Arithmetic& arithmetic, const Voxel<Word>& voxel, const Offer<Word>& term) const {
        float cosine = 0;
        for (int axis = 0; axis < 3; ++axis) cosine += voxel.normal[std::size_t(axis)] * float(setup_.travel[axis]);
        const float leaving = std::clamp(cosine, 0.0f, 1.0f), arriving = std::clamp(-cosine, 0.0f, 1.0f);
        const Word shot = arithmetic.partWord(double(leaving) * setup_.ofSurface);
        if (!(arriving > 0)) return {Word{}, shot};
        return {setup_.printed ? arithmetic.partOf(term.part, arithmetic.partWord(double(arriving))) : term.part, shot};
    }

    Offer<Word> illuminated(const Arithmetic& arithmetic, Voxel<Word>& voxel, Word ray) const {
        Offer<Word> term = terms(voxel);
        if (hasSurface(voxel)) term = atSurface(arithmetic, voxel, term);
        const Word in = arithmetic.partOf(ray, term.part);
        Word out = arithmetic.partOf(voxel.unshot, term.given);
        // Codes of the parts that a group shoots, and powers that are rounded, may add up to more than there is.
        if (!Arithmetic::kExact && setup_.group) out = std::min(out, voxel.unshot + voxel.fresh);
        const Word scattered = arithmetic.partOf(in, voxel.gain);
        Word& changed = setup_.group ? voxel.fresh : voxel.unshot;
        changed = arithmetic.add(arithmetic.subtract(changed, out), scattered);
        if (setup_.inject) changed = arithmetic.add(changed, voxel.source);
        if (setup_.group && setup_.settle) {
            voxel.unshot = arithmetic.add(voxel.unshot, voxel.fresh);
            voxel.fresh = {};
        }
        voxel.deposit = arithmetic.accumulate(voxel.deposit, in);
        // A ray that has its voxel for itself is told the change: what rounding took from one, the other has.
        if (!linear_) return {Word{}, arithmetic.subtract(out, in)};
        return {term.part, out};
    }

    void correct(const Arithmetic& arithmetic, Voxel<Word>& voxel, Ray<Word> mean) const {
        if (setup_.several) {
            mean = {arithmetic.accumulate(voxel.fresh, mean.value), arithmetic.accumulate(voxel.deposit, mean.weight)};
            voxel.fresh = setup_.settle ? Word{} : mean.value;
            voxel.deposit = setup_.settle ? Word{} : mean.weight;
            if (!setup_.settle) return;
        }
        if (voxel.gain == Word{} || mean.weight == Word{}) return;
        voxel.scalar = arithmetic.corrected(voxel.scalar, mean, setup_.bounds, setup_.relaxation);
    }

    const bool linear_;
    const ExchangeSetup<Word>& setup_;
};

}  // namespace raysweep::cube4
