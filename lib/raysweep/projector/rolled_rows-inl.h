// What projector and backprojector of leaning rows (rolled.h) take from the same expressions. Included once per
// instruction set.
#if defined(RAYSWEEP_PROJECTOR_ROLLED_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_PROJECTOR_ROLLED_ROWS_INL_H
#undef RAYSWEEP_PROJECTOR_ROLLED_ROWS_INL_H
#else
#define RAYSWEEP_PROJECTOR_ROLLED_ROWS_INL_H
#endif

#include "raysweep/projector/column_kernels-inl.h"
#include "raysweep/projector/rolled.h"

#include <algorithm>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// Z of rows from `row` on: z(v) of rolled.h.
HWY_INLINE Vec heightsFrom(const LeaningRows& rows, int row) {
    const Vec v = hn::Iota(kLanes, float(row));
    return hn::Div(hn::MulAdd(v, hn::Set(kLanes, rows.b), hn::Set(kLanes, rows.a)),
                   hn::MulAdd(v, hn::Set(kLanes, rows.d), hn::Set(kLanes, rows.c)));
}

HWY_INLINE Vec lateralAt(const LeaningRows& rows, Vec z) {
    return hn::MulAdd(hn::Set(kLanes, rows.lean), z, hn::Set(kLanes, rows.offset));
}

/// Columns of voxels beside the line between two heights, within [low, high).
HWY_INLINE IndexRange beside(const LeaningRows& rows, float z0, float z1, IndexRange within) {
    constexpr float kRounding = 1e-3f;
    const float l0 = rows.lateral(z0), l1 = rows.lateral(z1), most = 1e6f;
    const float low = std::clamp(std::min(l0, l1) - kRounding, -most, most);
    const float high = std::clamp(std::max(l0, l1) + kRounding, -most, most);
    const IndexRange met{std::max(within.first, int(std::floor(low))),
                         std::min(within.last, int(std::floor(high)) + 2)};
    return met.first < met.last ? met : IndexRange{};
}

/// Rows between two heights, and some more.
HWY_INLINE IndexRange rowsBetween(const LeaningRows& rows, float z0, float z1, int count) {
    // Beyond the outermost rows their plane may have no row at a height at all.
    const float low = rows.at(0), high = rows.at(float(count - 1));
    if (z1 < low || z0 > high) return {};
    const int first = z0 <= low ? 0 : std::max(0, int(rows.rowAt(z0)) - 1);
    const int last = z1 >= high ? count : std::min(count, int(rows.rowAt(z1)) + 3);
    return {first, last};
}

/// Numbers behind some place, in two vectors.
struct Nearby {
    Vec low, high;
    HWY_INLINE explicit Nearby(const float* from)
        : low(hn::LoadU(kLanes, from)), high(hn::LoadU(kLanes, from + kLaneCount)) {}
    HWY_INLINE Vec operator[](const Lookup& lookup) const { return lookup(low, high); }

    /// True if numbers up to `last` behind are there.
    static bool reaches(int last) { return kLaneCount > 1 && last < 2 * kLaneCount; }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
