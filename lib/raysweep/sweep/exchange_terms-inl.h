// What a voxel does to a ray, eight voxels at a time: the equations of exchange.h. Included once per instruction set.
#if defined(RAYSWEEP_SWEEP_EXCHANGE_TERMS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_SWEEP_EXCHANGE_TERMS_INL_H
#undef RAYSWEEP_SWEEP_EXCHANGE_TERMS_INL_H
#else
#define RAYSWEEP_SWEEP_EXCHANGE_TERMS_INL_H
#endif

#include "raysweep/sweep/exchange.h"

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<float, kBrickEdge>;
using Vec = hn::Vec<Lanes>;
constexpr Lanes kLanes;

// Below this optical depth a voxel is as good as empty; it keeps alpha / tau from being 0 / 0.
constexpr float kThinnest = 1e-30f;

/// What a row of voxels does to any ray that passes it along the sweep's direction.
struct RowTerms {
    Vec opacity;    ///< alpha
    Vec shot;       ///< out / U
    Vec numerator;  ///< of the escape probability
    Vec denominator;
};

HWY_INLINE Vec polynomial(Vec t, float c1, float c2, float c3, float c4) {
    const Vec inner = hn::MulAdd(t, hn::Set(kLanes, c4), hn::Set(kLanes, c3));
    const Vec middle = hn::MulAdd(t, inner, hn::Set(kLanes, c2));
    return hn::MulAdd(t, hn::MulAdd(t, middle, hn::Set(kLanes, c1)), hn::Set(kLanes, 1.0f));
}

template <MediumExchange kModel>
HWY_INLINE RowTerms rowTerms(const ExchangeStep& step, Vec tau) {
    const Vec one = hn::Set(kLanes, 1.0f);
    const Vec along = hn::Max(hn::Mul(tau, hn::Set(kLanes, step.stepScale)), hn::Set(kLanes, kThinnest));
    RowTerms terms;
    terms.opacity = hn::Min(hn::Neg(hn::Expm1(kLanes, hn::Neg(along))), one);
    if (kModel == MediumExchange::paper) {
        terms.shot = hn::Set(kLanes, step.zeta);
        terms.numerator = terms.denominator = one;
        return terms;
    }
    const float* a = step.escape.a;
    const float* b = step.escape.b;
    terms.numerator = polynomial(tau, b[0], b[1], b[2], 0.0f);
    terms.denominator = polynomial(tau, a[0], a[1], a[2], a[3]);
    const Vec ratio = hn::Div(hn::Mul(terms.opacity, terms.denominator), hn::Mul(along, terms.numerator));
    terms.shot = hn::Min(hn::Mul(ratio, hn::Set(kLanes, step.zeta)), one);
    return terms;
}

/// g = albedo p / (1 - albedo (1 - p)) with p = n / d. Written without a difference of n and d: where p is below the
/// precision of a float, that would lose n and with it the power.
HWY_INLINE Vec effectiveAlbedo(const RowTerms& terms, Vec albedo) {
    const Vec scattered = hn::Mul(albedo, terms.numerator);
    const Vec absorbing = hn::Sub(hn::Set(kLanes, 1.0f), albedo);
    return hn::Div(scattered, hn::MulAdd(absorbing, terms.denominator, scattered));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
