// What the exchange does to a brick as a whole, without rays. Compiled once per instruction set; the best one that the
// machine has is chosen at run time.
#include "raysweep/sweep/exchange.h"

#include <algorithm>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/sweep/exchange.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/sweep/exchange_terms-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// 1 / p of the voxels at `i`, and where they are surfaces 1.
HWY_INLINE Vec inverseEscapeAt(const ExchangeConstants& constants, const PackedNormal* normals, int i, Vec tau) {
    const Vec inverse = inverseEscape(constants, tau);
    return normals ? withoutEscape(normals + i, inverse) : inverse;
}

template <bool kThinOnly>
void settle(const std::vector<Beam>& beams, const ExchangeFields& fields, const ExchangeConstants& constants,
            const PackedNormal* normals, std::size_t b) {
    const ExchangeRule rule(constants);
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes))) {
        const Vec tau = hn::Load(kLanes, fields.tau.brick(b) + i);
        const Vec inverse = inverseEscapeAt(constants, normals, i, tau);
        const Vec shotPart = hn::Mul(inverse, hn::Set(kLanes, rule.part));
        VoxelSurfaces surfaces;
        if (normals) surfaces = voxelSurfaces(normals + i, tau);
        Vec shot = hn::Zero(kLanes);
        for (const Beam& beam : beams) {
            if (rule.asPrinted && !normals) {  // no need of the terms
                shot = hn::Add(shot, hn::Set(kLanes, rule.most));
                continue;
            }
            VoxelTerms terms = voxelTerms<kThinOnly>(rule, beam.stepScale, tau, shotPart);
            if (normals) applySurfaces(rule, beam.front.direction, surfaces, terms);
            shot = hn::Add(shot, terms.shot);
        }
        const Vec times = hn::Set(kLanes, float(beams.size()));
        for (int c = 0; c < fields.channels; ++c) {
            float* const unshot = fields.unshot[c].brick(b) + i;
            float* const deposit = fields.deposit[c].brick(b) + i;
            float* const fresh = fields.fresh[c].brick(b) + i;
            const Vec U = hn::Load(kLanes, unshot), in = hn::Load(kLanes, fresh);
            const Vec g = effectiveAlbedo(inverse, hn::Load(kLanes, fields.albedo[c].brick(b) + i));
            const Vec left =
                hn::MulAdd(hn::Load(kLanes, fields.source[c].brick(b) + i), times, hn::Sub(U, hn::Mul(U, shot)));
            hn::Store(hn::MulAdd(g, in, left), kLanes, unshot);
            hn::Store(hn::Add(hn::Load(kLanes, deposit), in), kLanes, deposit);
            hn::Store(hn::Zero(kLanes), kLanes, fresh);
        }
    }
}

}  // namespace

void settleDispatched(const std::vector<Beam>& beams, const ExchangeFields& fields, const ExchangeConstants& constants,
                      std::size_t b) {
    const PackedNormal* const normals = fields.surfaces ? fields.surfaces->normals(b) : nullptr;
    const float* const tau = fields.tau.brick(b);
    float mostScale = 0;
    for (const Beam& beam : beams) mostScale = std::max(mostScale, beam.stepScale);
    const bool thin = !normals && *std::max_element(tau, tau + kBrickVoxels) * mostScale <= kThin;
    thin ? settle<true>(beams, fields, constants, normals, b) : settle<false>(beams, fields, constants, normals, b);
}

void effectiveAlbedosDispatched(const ExchangeConstants& constants, const PackedNormal* normals, const float* tau,
                                const float* albedo, float* g) {
    for (int i = 0; i < kBrickVoxels; i += int(hn::Lanes(kLanes))) {
        const Vec depth = hn::Load(kLanes, tau + i);
        const Vec inverse = inverseEscapeAt(constants, normals, i, depth);
        hn::Store(effectiveAlbedo(inverse, hn::Load(kLanes, albedo + i)), kLanes, g + i);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

SweptBeams::SweptBeams(const std::vector<Beam>& beams, std::vector<FrontRays>& rays) {
    for (std::size_t i = 0; i < beams.size(); ++i)
        (beams[i].front.columnsUp() == beams[0].front.columnsUp() ? along : against).push_back({&beams[i], &rays[i]});
}

float SweptBeams::mostStepScale() const {
    float most = 0;
    for (const auto* beams : {&along, &against})
        for (const SweptBeam& swept : *beams) most = std::max(most, swept.beam->stepScale);
    return most;
}

std::size_t endOfRow(const std::vector<BrickVisit>& visits, std::size_t first) {
    std::size_t end = first + 1;
    while (end < visits.size() && visits[end].slice == visits[first].slice && visits[end].row == visits[first].row)
        ++end;
    return end;
}

HWY_EXPORT(settleDispatched);
HWY_EXPORT(effectiveAlbedosDispatched);

void settleBrick(const std::vector<Beam>& beams, const ExchangeFields& fields, const ExchangeConstants& constants,
                 std::size_t b) {
    HWY_DYNAMIC_DISPATCH(settleDispatched)(beams, fields, constants, b);
}

void effectiveAlbedos(const ExchangeConstants& constants, const PackedNormal* normals, const float* tau,
                      const float* albedo, float* g) {
    HWY_DYNAMIC_DISPATCH(effectiveAlbedosDispatched)(constants, normals, tau, albedo, g);
}

}  // namespace raysweep
#endif  // HWY_ONCE
