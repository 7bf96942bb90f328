// Turns the planes of a brick. Included once per instruction set.
#if defined(RAYSWEEP_SWEEP_TRANSPOSE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_SWEEP_TRANSPOSE_INL_H
#undef RAYSWEEP_SWEEP_TRANSPOSE_INL_H
#else
#define RAYSWEEP_SWEEP_TRANSPOSE_INL_H
#endif

#include "raysweep/bricks/bricks.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
template <class T>
HWY_INLINE void transposePlane(const T* HWY_RESTRICT from, T* HWY_RESTRICT to) {
    for (int i = 0; i < kBrickEdge; ++i)
        for (int j = 0; j < kBrickEdge; ++j) to[8 * i + j] = from[8 * j + i];
}
#else
/// 8x8 transpose in 4x4 blocks: to[8 i + j] = from[8 j + i].
template <class T>
HWY_INLINE void transposePlane(const T* HWY_RESTRICT from, T* HWY_RESTRICT to) {
    namespace hn = hwy::HWY_NAMESPACE;
    using Quad = hn::CappedTag<T, 4>;
    constexpr Quad quad;
    const hn::Repartition<double, Quad> pair;
    for (int i = 0; i < kBrickEdge; i += 4)
        for (int j = 0; j < kBrickEdge; j += 4) {
            const auto a = hn::Load(quad, from + 8 * (j + 0) + i), b = hn::Load(quad, from + 8 * (j + 1) + i);
            const auto c = hn::Load(quad, from + 8 * (j + 2) + i), d = hn::Load(quad, from + 8 * (j + 3) + i);
            const auto ab0 = hn::BitCast(pair, hn::InterleaveLower(quad, a, b));
            const auto ab1 = hn::BitCast(pair, hn::InterleaveUpper(quad, a, b));
            const auto cd0 = hn::BitCast(pair, hn::InterleaveLower(quad, c, d));
            const auto cd1 = hn::BitCast(pair, hn::InterleaveUpper(quad, c, d));
            hn::Store(hn::BitCast(quad, hn::InterleaveLower(pair, ab0, cd0)), quad, to + 8 * (i + 0) + j);
            hn::Store(hn::BitCast(quad, hn::InterleaveUpper(pair, ab0, cd0)), quad, to + 8 * (i + 1) + j);
            hn::Store(hn::BitCast(quad, hn::InterleaveLower(pair, ab1, cd1)), quad, to + 8 * (i + 2) + j);
            hn::Store(hn::BitCast(quad, hn::InterleaveUpper(pair, ab1, cd1)), quad, to + 8 * (i + 3) + j);
        }
}
#endif

/// Planes [first, last] of a brick; a plane is 64 values of one x.
template <class T>
HWY_INLINE void transposePlanes(const T* from, T* to, int first, int last) {
    for (int x = first; x <= last; ++x) transposePlane(from + 64 * x, to + 64 * x);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
