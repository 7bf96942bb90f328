// Between a column of voxels and the detector's rows, which cross it at equal distances: linear interpolation, and its
// transpose. Included once per instruction set.
#if defined(RAYSWEEP_SWEEP_COLUMN_KERNELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_SWEEP_COLUMN_KERNELS_INL_H
#undef RAYSWEEP_SWEEP_COLUMN_KERNELS_INL_H
#else
#define RAYSWEEP_SWEEP_COLUMN_KERNELS_INL_H
#endif

#include "raysweep/projector/fan_image.h"

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<float, 16>;  // columns are cut at multiples of 16
using IntLanes = hn::RebindToSigned<Lanes>;
using Vec = hn::Vec<Lanes>;
using IntVec = hn::Vec<IntLanes>;
constexpr Lanes kLanes;
constexpr IntLanes kIntLanes;
constexpr int kLaneCount = int(hn::MaxLanes(kLanes));

/// Row v of the detector crosses a column at z = height + pitch v, pitch > 0.
struct RowPositions {
    float height, pitch;

    float at(int row) const { return height + pitch * float(row); }

    /// The first of the rows that may lie above z: none before it does.
    int firstAbove(float z) const { return int(std::floor(std::clamp((z - height) / pitch, -1e6f, 1e6f))); }
};

/// What values lie `index` behind `from`, each index less than twice the lanes.
struct Lookup {
    decltype(hn::IndicesFromVec(kLanes, hn::Zero(kIntLanes))) index;
    hn::Mask<Lanes> isNear;

    HWY_INLINE explicit Lookup(IntVec behind)
        : index(hn::IndicesFromVec(kLanes, hn::And(behind, hn::Set(kIntLanes, kLaneCount - 1)))),
          isNear(hn::RebindMask(kLanes, hn::Lt(behind, hn::Set(kIntLanes, kLaneCount)))) {}

    HWY_INLINE Vec operator()(const float* from) const {
        const Vec near = hn::TableLookupLanes(hn::LoadU(kLanes, from), index);
        const Vec far = hn::TableLookupLanes(hn::LoadU(kLanes, from + kLaneCount), index);
        return hn::IfThenElse(isNear, near, far);
    }
};

/// Pitches for which the positions of neighbouring lanes are so near to each other that Lookup reaches them, both ways.
HWY_INLINE bool fitsLookup(float pitch) {
    return kLaneCount > 1 && pitch >= 0.51f && pitch * float(kLaneCount - 1) <= float(2 * kLaneCount - 3);
}

/// sum += weight * values, whole vectors.
HWY_INLINE void addScaled(float* HWY_RESTRICT sum, const float* HWY_RESTRICT values, float weight, int count) {
    const Vec w = hn::Set(kLanes, weight);
    for (int i = 0; i < count; i += kLaneCount)
        hn::StoreU(hn::MulAdd(w, hn::LoadU(kLanes, values + i), hn::LoadU(kLanes, sum + i)), kLanes, sum + i);
}

/// The rows that can meet voxels [low, high).
struct RowRange {
    int first, last;
};
HWY_INLINE RowRange rowsMeeting(const RowPositions& rows, int low, int high, int rowCount) {
    return {std::max(0, rows.firstAbove(float(low - 1))), std::min(rowCount, rows.firstAbove(float(high)) + 2)};
}

/// sum[v] += the column's value where row v crosses it. `column` holds zeros around [low, high).
HWY_INLINE void addInterpolated(const float* column, int low, int high, const RowPositions& rows, float* sum,
                                int rowCount) {
    const RowRange range = rowsMeeting(rows, low, high, rowCount);
    if (!fitsLookup(rows.pitch)) {
        for (int v = range.first; v < range.last; ++v) {
            const float z = rows.at(v), below = std::floor(z);
            const int k = std::clamp(int(below), low - 1, high);
            const float part = std::clamp(z - float(k), 0.0f, 1.0f);
            sum[v] += column[k] + part * (column[k + 1] - column[k]);
        }
        return;
    }
    const Vec pitch = hn::Set(kLanes, rows.pitch), height = hn::Set(kLanes, rows.height);
    const Vec first = hn::Set(kLanes, float(low - 1)), last = hn::Set(kLanes, float(high));
    const Vec zero = hn::Zero(kLanes), one = hn::Set(kLanes, 1.0f);
    for (int v = range.first; v < range.last; v += kLaneCount) {
        const Vec z = hn::MulAdd(pitch, hn::Iota(kLanes, float(v)), height);
        const Vec below = hn::Min(hn::Max(hn::Floor(z), first), last);
        const Vec part = hn::Min(hn::Max(hn::Sub(z, below), zero), one);
        const IntVec k = hn::ConvertTo(kIntLanes, below);
        const int base = hn::GetLane(k);
        const Lookup lookup(hn::Sub(k, hn::Set(kIntLanes, base)));
        const Vec here = lookup(column + base), next = lookup(column + base + 1);
        const Vec value = hn::MulAdd(part, hn::Sub(next, here), here);
        // Rows behind the last are written as well: beyond the detector their sums are cleared by the caller.
        hn::StoreU(hn::Add(hn::LoadU(kLanes, sum + v), value), kLanes, sum + v);
    }
}

/// As addInterpolated for a column of `weight` everywhere in [low, high).
HWY_INLINE void addCoverage(float weight, int low, int high, const RowPositions& rows, float* sum, int rowCount) {
    const RowRange range = rowsMeeting(rows, low, high, rowCount);
    const Vec pitch = hn::Set(kLanes, rows.pitch), height = hn::Set(kLanes, rows.height);
    const Vec before = hn::Set(kLanes, float(low - 1)), behind = hn::Set(kLanes, float(high));
    const Vec zero = hn::Zero(kLanes), one = hn::Set(kLanes, 1.0f), w = hn::Set(kLanes, weight);
    for (int v = range.first; v < range.last; v += kLaneCount) {
        const Vec z = hn::MulAdd(pitch, hn::Iota(kLanes, float(v)), height);
        const Vec inside = hn::Min(hn::Sub(z, before), hn::Sub(behind, z));
        const Vec part = hn::Min(hn::Max(inside, zero), one);
        hn::StoreU(hn::MulAdd(w, part, hn::LoadU(kLanes, sum + v)), kLanes, sum + v);
    }
}

/// The transpose of addInterpolated for two images at once: to0[z] = sum over rows of weight(v, z) from0[v], z in
/// [low, high), multiples of 16. `from` has FanImage's margins around its rows.
HWY_INLINE void gatherRows(const float* from0, const float* from1, int rowCount, const RowPositions& rows, float* to0,
                           float* to1, int low, int high) {
    if (!fitsLookup(rows.pitch)) {
        std::fill(to0 + low, to0 + high, 0.0f);
        std::fill(to1 + low, to1 + high, 0.0f);
        const RowRange range = rowsMeeting(rows, low, high, rowCount);
        for (int v = range.first; v < range.last; ++v) {
            const float z = rows.at(v), below = std::floor(z), part = z - below;
            if (below < float(low - 1) || below >= float(high)) continue;
            const int k = int(below);
            if (k >= low) {
                to0[k] += (1 - part) * from0[v];
                to1[k] += (1 - part) * from1[v];
            }
            if (k + 1 < high) {
                to0[k + 1] += part * from0[v];
                to1[k + 1] += part * from1[v];
            }
        }
        return;
    }
    const int taps = int(std::ceil(2 / rows.pitch));
    const Vec height = hn::Set(kLanes, rows.height), pitch = hn::Set(kLanes, rows.pitch);
    const Vec inverse = hn::Set(kLanes, 1 / rows.pitch);
    const Vec zero = hn::Zero(kLanes), one = hn::Set(kLanes, 1.0f);
    // Rows off the detector are taken from the margins, where there is nothing.
    const Vec least = hn::Set(kLanes, float(-taps)), most = hn::Set(kLanes, float(rowCount));
    for (int z = low; z < high; z += kLaneCount) {
        const Vec level = hn::Iota(kLanes, float(z));
        const Vec start = hn::Add(hn::Floor(hn::Mul(hn::Sub(hn::Sub(level, one), height), inverse)), one);
        const IntVec row = hn::ConvertTo(kIntLanes, hn::Min(hn::Max(start, least), most));
        const int base = hn::GetLane(row);
        const Lookup lookup(hn::Sub(row, hn::Set(kIntLanes, base)));
        // Distance of the row from the voxel, in voxels.
        Vec distance = hn::Sub(hn::MulAdd(pitch, start, height), level);
        Vec sum0 = zero, sum1 = zero;
        for (int tap = 0; tap < taps; ++tap) {
            const Vec weight = hn::Max(hn::Sub(one, hn::Abs(distance)), zero);
            sum0 = hn::MulAdd(weight, lookup(from0 + base + tap), sum0);
            sum1 = hn::MulAdd(weight, lookup(from1 + base + tap), sum1);
            distance = hn::Add(distance, pitch);
        }
        hn::StoreU(sum0, kLanes, to0 + z);
        hn::StoreU(sum1, kLanes, to1 + z);
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif
