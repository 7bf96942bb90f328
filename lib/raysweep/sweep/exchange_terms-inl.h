// What a voxel does to a ray, eight voxels at a time: the equations of exchange.h. Included once per instruction set.
#if defined(RAYSWEEP_SWEEP_EXCHANGE_TERMS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_SWEEP_EXCHANGE_TERMS_INL_H
#undef RAYSWEEP_SWEEP_EXCHANGE_TERMS_INL_H
#else
#define RAYSWEEP_SWEEP_EXCHANGE_TERMS_INL_H
#endif

#include "raysweep/sweep/exchange.h"

#include <hwy/highway.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<float, kBrickEdge>;
using Vec = hn::Vec<Lanes>;
constexpr Lanes kLanes;

/// What voxels side by side, as many as a vector has lanes, do to rays of one direction.
struct VoxelTerms {
    Vec opacity;  ///< alpha
    Vec shot;     ///< out / U
};

/// 1 + c[0] t + ... + c[n - 1] t^n
template <int n>
HWY_INLINE Vec polynomial(Vec t, const float (&c)[n]) {
    Vec sum = hn::Set(kLanes, c[n - 1]);
    for (int k = n - 1; k-- > 0;) sum = hn::MulAdd(t, sum, hn::Set(kLanes, c[k]));
    return hn::MulAdd(t, sum, hn::Set(kLanes, 1.0f));
}

/// 1/x to about 1e-7, where the estimate is good enough by a Newton step, which is quicker than a division.
HWY_INLINE Vec reciprocal(Vec x) {
#if !HWY_ARCH_X86
    return hn::Div(hn::Set(kLanes, 1.0f), x);
#else
    const Vec estimate = hn::ApproximateReciprocal(x);
    return hn::Mul(estimate, hn::NegMulAdd(x, estimate, hn::Set(kLanes, 2.0f)));
#endif
}

/// 1 - exp(-x) for x >= 0, to 4e-7 of itself however small x is. With x = n ln 2 + r it is (1 - 2^-n) + 2^-n (1 -
/// exp(-r)), |r| <= ln 2 / 2, and the last term is a Taylor series without its constant.
HWY_INLINE Vec opacityOf(Vec x) {
    constexpr float kInverseLn2 = 1.44269504f, kLn2High = 0.693359375f, kLn2Low = -2.12194440e-4f, kOpaque = 80.0f;
    const hn::RebindToSigned<Lanes> kWholes;
    x = hn::Min(x, hn::Set(kLanes, kOpaque));
    const Vec n = hn::Round(hn::Mul(x, hn::Set(kLanes, kInverseLn2)));
    const Vec r = hn::NegMulAdd(n, hn::Set(kLanes, kLn2Low), hn::NegMulAdd(n, hn::Set(kLanes, kLn2High), x));
    Vec series = hn::Set(kLanes, 1.0f / 5040);
    for (const float c : {1.0f / 720, 1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f, 1.0f})
        series = hn::NegMulAdd(series, r, hn::Set(kLanes, c));
    const auto exponent = hn::Sub(hn::Set(kWholes, 127), hn::ConvertTo(kWholes, n));
    const Vec power = hn::BitCast(kLanes, hn::ShiftLeft<23>(exponent));
    return hn::MulAdd(power, hn::Mul(series, r), hn::Sub(hn::Set(kLanes, 1.0f), power));
}

/// (1 - exp(-x)) / x for x in [0, kThin]: 1 + x h(x), with h interpolated at Chebyshev nodes, to 2.1e-7 of itself.
constexpr float kThin = 1.5f;
HWY_INLINE Vec thinOpacityOverDepth(Vec x) {
    Vec series = hn::Set(kLanes, 1.15021859e-4f);
    for (const float c : {-1.26198873e-3f, 8.23936973e-3f, -4.16344736e-2f, 1.66662579e-1f, -4.99999915e-1f, 1.0f})
        series = hn::MulAdd(series, x, hn::Set(kLanes, c));
    return series;
}

/// What both models have in common, so that kernels are compiled once: each is a choice of numbers. Not the escape
/// probability, which is found once for a brick.
///
///     out / U = min(most, part / p alpha / (s len))
///
/// As printed the algorithm shoots zeta whatever the voxel: there p = 1, `most` is zeta, and `part` so large that the
/// other side of the minimum is never less.
struct ExchangeRule {
    static constexpr float kAnyPart = 1e30f;  ///< times 1 / (s len) of the thickest voxel it is far above 1
    float part, most;
    float ofSurface;  ///< out / U of a surface is this times the cosine
    bool asPrinted, direct;

    explicit ExchangeRule(const ExchangeConstants& constants)
        : part(constants.zeta),
          most(constants.mostShot),
          ofSurface(std::min(constants.mostShot, 4 * constants.zeta)),
          asPrinted(constants.model == ExchangeModel::asPrinted),
          direct(constants.direct && !asPrinted) {
        if (!asPrinted) return;
        part = kAnyPart;
        most = ofSurface = std::min(constants.mostShot, constants.zeta);
    }
};

/// 1 / p, with p the escape probability.
HWY_INLINE Vec inverseEscape(const ExchangeConstants& constants, Vec tau) {
    if (constants.model == ExchangeModel::asPrinted) return hn::Set(kLanes, 1.0f);
    return hn::Mul(polynomial(tau, constants.escape.a), reciprocal(polynomial(tau, constants.escape.b)));
}

/// Terms of voxels without a surface. With `kThinOnly` tau `stepScale` is at most kThin, and a polynomial does.
/// @param shotPart `part` / p
template <bool kThinOnly>
HWY_INLINE VoxelTerms voxelTerms(const ExchangeRule& rule, float stepScale, Vec tau, Vec shotPart) {
    const Vec along = hn::Mul(tau, hn::Set(kLanes, stepScale));
    VoxelTerms terms;
    Vec perDepth;  // opacity / along
    if (kThinOnly) {
        perDepth = thinOpacityOverDepth(along);
        terms.opacity = hn::Mul(along, perDepth);
    } else {
        // An empty voxel takes nothing, but alpha / tau must not be 0 / 0: what is emitted in it leaves.
        const Vec depth = hn::Max(along, hn::Set(kLanes, kThinnest));
        const Vec opacity = hn::Min(opacityOf(depth), hn::Set(kLanes, 1.0f));
        terms.opacity = hn::IfThenElseZero(hn::Gt(tau, hn::Zero(kLanes)), opacity);
        perDepth = hn::Mul(opacity, reciprocal(depth));
    }
    terms.shot = hn::Min(hn::Mul(shotPart, perDepth), hn::Set(kLanes, rule.most));
    return terms;
}

/// Where rays are as regards solids.
struct VoxelSolids {
    hn::Mask<Lanes> inside;   ///< at a surface where they arrive, or behind one
    hn::Mask<Lanes> leaving;  ///< at a surface where they leave
};

/// Component `axis` of packed normals.
HWY_INLINE Vec normalComponent(hn::Vec<hn::RebindToSigned<Lanes>> packed, int axis) {
    const auto shifted = axis == 0   ? hn::ShiftLeft<22>(packed)
                         : axis == 1 ? hn::ShiftLeft<12>(packed)
                                     : hn::ShiftLeft<2>(packed);
    return hn::ConvertTo(kLanes, hn::ShiftRight<22>(shifted));
}

/// What is known of the surfaces of voxels whatever the direction.
struct VoxelSurfaces {
    hn::Mask<Lanes> surface;  ///< has a normal
    hn::Mask<Lanes> present;  ///< and is not empty, as the voxels of a quad light are
    hn::Mask<Lanes> solid;    ///< present, or inside of a solid
    Vec normal[3];
};

HWY_INLINE hn::Mask<Lanes> hasSurfaceBit(hn::Vec<hn::RebindToSigned<Lanes>> packed) {
    const hn::RebindToSigned<Lanes> kWholes;
    return hn::RebindMask(kLanes, hn::TestBit(packed, hn::Set(kWholes, std::int32_t(kSurfaceBit))));
}

HWY_INLINE VoxelSurfaces voxelSurfaces(const PackedNormal* normals, Vec tau) {
    const hn::RebindToSigned<Lanes> kWholes;
    const auto packed = hn::BitCast(kWholes, hn::Load(hn::RebindToUnsigned<Lanes>(), normals));
    VoxelSurfaces surfaces;
    const auto present = hn::Gt(tau, hn::Zero(kLanes));
    surfaces.surface = hasSurfaceBit(packed);
    surfaces.present = hn::And(surfaces.surface, present);
    surfaces.solid = hn::And(hn::RebindMask(kLanes, hn::Ne(packed, hn::Zero(kWholes))), present);
    for (int axis = 0; axis < 3; ++axis) surfaces.normal[axis] = normalComponent(packed, axis);
    return surfaces;
}

/// Changes the terms of voxels that have a surface, for rays that travel along `direction`.
HWY_INLINE VoxelSolids applySurfaces(const ExchangeRule& rule, const Vec3& direction, const VoxelSurfaces& surfaces,
                                     VoxelTerms& terms) {
    Vec cosine = hn::Zero(kLanes);
    for (int axis = 0; axis < 3; ++axis)
        cosine = hn::MulAdd(surfaces.normal[axis], hn::Set(kLanes, float(direction[axis]) / kPackedSteps), cosine);
    const Vec zero = hn::Zero(kLanes), one = hn::Set(kLanes, 1.0f);
    Vec taken = terms.opacity;
    if (rule.asPrinted) taken = hn::Mul(taken, hn::Min(hn::Neg(cosine), one));
    if (!rule.direct)
        terms.opacity =
            hn::IfThenElse(surfaces.surface, hn::IfThenElseZero(hn::Lt(cosine, zero), taken), terms.opacity);
    terms.shot = hn::IfThenElse(
        surfaces.surface, hn::Mul(hn::Min(hn::Max(cosine, zero), one), hn::Set(kLanes, rule.ofSurface)), terms.shot);
    const auto leaving = hn::And(surfaces.present, hn::Gt(cosine, hn::Set(kLanes, kLeavingCosine)));
    return {hn::AndNot(leaving, surfaces.solid), leaving};
}

/// 1 / p where voxels of a surface are taken to scatter once: 1.
HWY_INLINE Vec withoutEscape(const PackedNormal* normals, Vec inverseEscape) {
    const auto packed = hn::BitCast(hn::RebindToSigned<Lanes>(), hn::Load(hn::RebindToUnsigned<Lanes>(), normals));
    return hn::IfThenElse(hasSurfaceBit(packed), hn::Set(kLanes, 1.0f), inverseEscape);
}

/// g = albedo p / (1 - albedo (1 - p)), written so that nothing is lost where p is below the precision of a float, and
/// divided so that albedo 1 gives 1: a reciprocal that falls short by a bit would absorb at every scattering.
HWY_INLINE Vec effectiveAlbedo(Vec inverseEscape, Vec albedo) {
    const Vec absorbing = hn::Sub(hn::Set(kLanes, 1.0f), albedo);
    return hn::Div(albedo, hn::MulAdd(absorbing, inverseEscape, albedo));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
