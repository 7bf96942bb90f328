// Between a column of voxels and the detector's rows, which cross it at equal distances: Joseph's weights along z
// (joseph.h, eq. 1), forward and adjoint, for whole vectors of rows or voxels. Included once per instruction set.
#if defined(RAYSWEEP_PROJECTOR_COLUMN_KERNELS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RAYSWEEP_PROJECTOR_COLUMN_KERNELS_INL_H
#undef RAYSWEEP_PROJECTOR_COLUMN_KERNELS_INL_H
#else
#define RAYSWEEP_PROJECTOR_COLUMN_KERNELS_INL_H
#endif

#include "raysweep/projector/joseph.h"
#include "raysweep/projector/ray_image.h"

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

/// Joseph's weights as joseph.h has them, w(z) = max(0, 1 - |z - k|), a lane for each row: `upper` is that of voxel
/// `below` + 1, 1 - upper that of voxel `below`.
struct LaneWeights {
    Vec below, upper;
};
HWY_INLINE LaneWeights besideRays(Vec z) {
    const Vec below = hn::Floor(z);
    return {below, hn::Sub(z, below)};
}

/// The same weight by the distance of voxel and row.
HWY_INLINE Vec weightAt(Vec distance) {
    return hn::Max(hn::Sub(hn::Set(kLanes, 1.0f), hn::Abs(distance)), hn::Zero(kLanes));
}

/// The sum of the weights of all voxels in (before, behind), whole numbers.
HWY_INLINE Vec weightBetween(Vec z, Vec before, Vec behind) {
    const Vec inside = hn::Min(hn::Sub(z, before), hn::Sub(behind, z));
    return hn::Min(hn::Max(inside, hn::Zero(kLanes)), hn::Set(kLanes, 1.0f));
}

/// Values of rays and what they are weighted by (ViewRays), or sums of these, beside each other.
template <class Float>
struct ValuesAndWeights {
    Float *values, *weights;
};

/// What values lie `index` behind `from`, each index less than twice the lanes.
struct Lookup {
    decltype(hn::IndicesFromVec(kLanes, hn::Zero(kIntLanes))) index;
    hn::Mask<Lanes> isNear;

    HWY_INLINE explicit Lookup(IntVec behind)
        : index(hn::IndicesFromVec(kLanes, hn::And(behind, hn::Set(kIntLanes, kLaneCount - 1)))),
          isNear(hn::RebindMask(kLanes, hn::Lt(behind, hn::Set(kIntLanes, kLaneCount)))) {}

    HWY_INLINE Vec operator()(const float* from) const {
        return (*this)(hn::LoadU(kLanes, from), hn::LoadU(kLanes, from + kLaneCount));
    }
    /// Of two vectors, one behind the other.
    HWY_INLINE Vec operator()(Vec near, Vec far) const {
        return hn::IfThenElse(isNear, hn::TableLookupLanes(near, index), hn::TableLookupLanes(far, index));
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

/// The rows that can meet voxels of `range`.
HWY_INLINE IndexRange rowsMeeting(const DetectorRows& rows, ColumnRange range) {
    return {std::max(0, rows.firstAbove(float(range.low - 1))),
            std::min(rows.count, rows.firstAbove(float(range.high)) + 2)};
}

/// sum[v] += the column's value where row v crosses it. `column` holds zeros around `range`.
HWY_INLINE void addInterpolated(const float* column, ColumnRange range, const DetectorRows& rows, float* sum) {
    const IndexRange met = rowsMeeting(rows, range);
    const float low = float(range.low - 1), high = float(range.high);  // 0 there and beyond
    if (!fitsLookup(rows.pitch)) {
        for (int v = met.first; v < met.last; ++v) {
            const LateralWeights w = besideRay(std::clamp(rows.at(v), low, high));
            const float* voxel = column + w.below;
            sum[v] += voxel[0] + w.upper * (voxel[1] - voxel[0]);
        }
        return;
    }
    const Vec pitch = hn::Set(kLanes, rows.pitch), height = hn::Set(kLanes, rows.height);
    const Vec least = hn::Set(kLanes, low), most = hn::Set(kLanes, high);
    for (int v = met.first; v < met.last; v += kLaneCount) {
        const Vec z = hn::MulAdd(pitch, hn::Iota(kLanes, float(v)), height);
        const LaneWeights w = besideRays(hn::Min(hn::Max(z, least), most));
        const IntVec k = hn::ConvertTo(kIntLanes, w.below);
        const int base = hn::GetLane(k);
        const Lookup lookup(hn::Sub(k, hn::Set(kIntLanes, base)));
        const Vec here = lookup(column + base), next = lookup(column + base + 1);
        const Vec value = hn::MulAdd(w.upper, hn::Sub(next, here), here);
        // Rows behind the last are written as well: beyond the detector their sums are cleared by the caller.
        hn::StoreU(hn::Add(hn::LoadU(kLanes, sum + v), value), kLanes, sum + v);
    }
}

/// As addInterpolated for a column of `weight` everywhere in `range`.
HWY_INLINE void addCoverage(float weight, ColumnRange range, const DetectorRows& rows, float* sum) {
    const IndexRange met = rowsMeeting(rows, range);
    const Vec pitch = hn::Set(kLanes, rows.pitch), height = hn::Set(kLanes, rows.height);
    const Vec before = hn::Set(kLanes, float(range.low - 1)), behind = hn::Set(kLanes, float(range.high));
    const Vec w = hn::Set(kLanes, weight);
    for (int v = met.first; v < met.last; v += kLaneCount) {
        const Vec z = hn::MulAdd(pitch, hn::Iota(kLanes, float(v)), height);
        hn::StoreU(hn::MulAdd(w, weightBetween(z, before, behind), hn::LoadU(kLanes, sum + v)), kLanes, sum + v);
    }
}

/// gatherRows for rows of any pitch, row by row.
HWY_INLINE void scatterRows(ValuesAndWeights<const float> from, const DetectorRows& rows, ColumnRange range,
                            ValuesAndWeights<float> to) {
    std::fill(to.values + range.low, to.values + range.high, 0.0f);
    std::fill(to.weights + range.low, to.weights + range.high, 0.0f);
    const IndexRange met = rowsMeeting(rows, range);
    for (int v = met.first; v < met.last; ++v) {
        const LateralWeights w = besideRay(rows.at(v));
        const int k = w.below;
        if (k >= range.low && k < range.high) {
            to.values[k] += w.lower * from.values[v];
            to.weights[k] += w.lower * from.weights[v];
        }
        if (k + 1 >= range.low && k + 1 < range.high) {
            to.values[k + 1] += w.upper * from.values[v];
            to.weights[k + 1] += w.upper * from.weights[v];
        }
    }
}

/// The adjoint of addInterpolated, for two images at once: to[z] = sum over rows of their weight at z times from[v], z
/// in `range`, multiples of 16. `from` has RayImage's margins around its rows.
HWY_INLINE void gatherRows(ValuesAndWeights<const float> from, const DetectorRows& rows, ColumnRange range,
                           ValuesAndWeights<float> to) {
    if (!fitsLookup(rows.pitch)) return scatterRows(from, rows, range, to);
    const int taps = int(std::ceil(2 / rows.pitch));
    const Vec height = hn::Set(kLanes, rows.height), pitch = hn::Set(kLanes, rows.pitch);
    const Vec inverse = hn::Set(kLanes, 1 / rows.pitch), one = hn::Set(kLanes, 1.0f);
    // Rows off the detector are taken from the margins, where there is nothing.
    const Vec least = hn::Set(kLanes, float(-taps)), most = hn::Set(kLanes, float(rows.count));
    for (int z = range.low; z < range.high; z += kLaneCount) {
        const Vec level = hn::Iota(kLanes, float(z));
        const Vec start = hn::Add(hn::Floor(hn::Mul(hn::Sub(hn::Sub(level, one), height), inverse)), one);
        const IntVec row = hn::ConvertTo(kIntLanes, hn::Min(hn::Max(start, least), most));
        const int base = hn::GetLane(row);
        const Lookup lookup(hn::Sub(row, hn::Set(kIntLanes, base)));
        // Distance of the row from the voxel, in voxels.
        Vec distance = hn::Sub(hn::MulAdd(pitch, start, height), level);
        Vec value = hn::Zero(kLanes), weight = hn::Zero(kLanes);
        for (int tap = 0; tap < taps; ++tap) {
            const Vec w = weightAt(distance);
            value = hn::MulAdd(w, lookup(from.values + base + tap), value);
            weight = hn::MulAdd(w, lookup(from.weights + base + tap), weight);
            distance = hn::Add(distance, pitch);
        }
        hn::StoreU(value, kLanes, to.values + z);
        hn::StoreU(weight, kLanes, to.weights + z);
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#endif
