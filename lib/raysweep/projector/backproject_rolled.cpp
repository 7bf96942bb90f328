// From rays to voxels: whole vectors of voxels. Compiled once per instruction set.
#include "raysweep/projector/rolled.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/backproject_rolled.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/rolled_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// Room for what a block needs of a detector column.
struct Scratch {
    std::vector<float> heights;  ///< z of each row, RayImage::kMargin around them; far away where there is no row
    std::vector<float> taps;     ///< of each row beside a vector of voxels: value, weight, lateral place

    static constexpr float kFar = 1e9f;
    explicit Scratch(int rowCount) : heights(std::size_t(rowCount) + 2 * RayImage::kMargin, kFar) {}
    float* height(int row) { return heights.data() + RayImage::kMargin + row; }
};

/// One block's voxels, and the sums in them.
struct RolledSums {
    const ColumnVolume& layout;
    std::size_t block;
    ValuesAndWeights<float> sums;
    Scratch& scratch;

    /// Adds detector column n in a slice, by voxels: the adjoint of RowVector::add.
    void add(const RolledColumn& column, ValuesAndWeights<const float> from, int rowCount, int slice) const {
        const ColumnRange range = layout.ranges()[block];
        const LeaningRows rows = column.rows(slice);
        const IndexRange across = lateralRange(column.axis);
        const float pitch = std::min(rows.pitch(0), rows.pitch(float(rowCount - 1)));
        const int taps = std::clamp(int(std::ceil(2 / pitch)), 1, RayImage::kMargin / 2);
        fillHeights(rows, range, rowCount, taps);
        const float lowest = rows.at(0), highest = rows.at(float(rowCount - 1));
        for (int z = range.low; z < range.high; z += kLaneCount) {
            const float low = float(z - 1), high = float(z + kLaneCount);
            const IndexRange columns = beside(rows, low, high, across);
            if (columns.first < columns.last)
                addVector(column, rows, from, {z, rowCount, taps, slice, lowest, highest}, columns);
        }
    }

  private:
    struct Place {
        int z, rowCount, taps, slice;
        float lowest, highest;  ///< z of the outermost rows
    };

    IndexRange lateralRange(int axis) const {
        const int first = axis == 0 ? layout.firstY(block) : layout.firstX(block);
        return {first, std::min(first + kBlockEdge, layout.lattice().dims[1 - axis])};
    }

    void fillHeights(const LeaningRows& rows, ColumnRange range, int rowCount, int taps) const {
        IndexRange met = rowsBetween(rows, float(range.low - 1), float(range.high), rowCount);
        met.last = std::min(rowCount, met.last + taps);
        for (int v = met.first; v < met.last; v += kLaneCount)
            hn::StoreU(heightsFrom(rows, v), kLanes, scratch.height(v));
        std::fill_n(scratch.height(rowCount), kLaneCount, Scratch::kFar);
    }

    void addVector(const RolledColumn& column, const LeaningRows& rows, ValuesAndWeights<const float> from,
                   const Place& at, IndexRange columns) const {
        const ColumnRange range = layout.ranges()[block];
        const Vec level = hn::Iota(kLanes, float(at.z)), one = hn::Set(kLanes, 1.0f);
        // The first row above z - 1, see LeaningRows::rowAt; beyond the outermost rows that has no meaning.
        const Vec below = hn::Sub(level, one), none = hn::Set(kLanes, float(at.rowCount));
        const Vec crossing = hn::Div(hn::NegMulAdd(below, hn::Set(kLanes, rows.c), hn::Set(kLanes, rows.a)),
                                     hn::MulSub(below, hn::Set(kLanes, rows.d), hn::Set(kLanes, rows.b)));
        const auto isAbove = hn::Ge(below, hn::Set(kLanes, at.lowest));
        const auto isBelow = hn::Lt(below, hn::Set(kLanes, at.highest));
        const Vec next = hn::Min(hn::Max(hn::Add(hn::Floor(crossing), one), hn::Zero(kLanes)), none);
        const Vec start = hn::IfThenElseZero(isAbove, hn::IfThenElse(isBelow, next, none));
        const IntVec row = hn::ConvertTo(kIntLanes, start);
        const int base = hn::GetLane(row);
        const IntVec behind = hn::Sub(row, hn::Set(kIntLanes, base));
        const bool isNear = Nearby::reaches(hn::ExtractLane(row, std::size_t(kLaneCount - 1)) - base + at.taps);
        const auto isVoxel = hn::Lt(level, hn::Set(kLanes, float(layout.lattice().dims.z)));
        float* room = scratch.taps.data();
        const auto keep = [&](Vec z, Vec value, Vec weight) {
            const Vec w = hn::IfThenElseZero(isVoxel, weightAt(hn::Sub(z, level)));
            hn::StoreU(hn::Mul(w, value), kLanes, room);
            hn::StoreU(hn::Mul(w, weight), kLanes, room + kLaneCount);
            hn::StoreU(lateralAt(rows, z), kLanes, room + 2 * kLaneCount);
            room += 3 * kLaneCount;
        };
        const float *heights = scratch.height(base), *values = from.values + base, *weights = from.weights + base;
        if (isNear) {
            const Nearby z(heights), value(values), weight(weights);
            for (int tap = 0; tap < at.taps; ++tap) {
                const Lookup lookup(hn::Add(behind, hn::Set(kIntLanes, tap)));
                keep(z[lookup], value[lookup], weight[lookup]);
            }
        } else {
            for (int tap = 0; tap < at.taps; ++tap) {
                const auto take = [&](const float* some) { return hn::GatherIndex(kLanes, some + tap, behind); };
                keep(take(heights), take(values), take(weights));
            }
        }
        for (int j = columns.first; j < columns.last; ++j) {
            const int x = column.voxelX(at.slice, j) - layout.firstX(block);
            const int y = column.voxelY(at.slice, j) - layout.firstY(block);
            const std::size_t offset =
                std::size_t(x * kBlockEdge + y) * std::size_t(range.length()) + std::size_t(at.z - range.low);
            addTaps(at.taps, float(j), {sums.values + offset, sums.weights + offset});
        }
    }

    /// Adds what the taps give to column j.
    HWY_INLINE void addTaps(int taps, float j, ValuesAndWeights<float> to) const {
        Vec value = hn::LoadU(kLanes, to.values), weight = hn::LoadU(kLanes, to.weights);
        const float* room = scratch.taps.data();
        for (int tap = 0; tap < taps; ++tap, room += 3 * kLaneCount) {
            const Vec w = weightAt(hn::Sub(hn::LoadU(kLanes, room + 2 * kLaneCount), hn::Set(kLanes, j)));
            value = hn::MulAdd(w, hn::LoadU(kLanes, room), value);
            weight = hn::MulAdd(w, hn::LoadU(kLanes, room + kLaneCount), weight);
        }
        hn::StoreU(value, kLanes, to.values);
        hn::StoreU(weight, kLanes, to.weights);
    }
};

/// Detector columns of `run` that in `slice` are at (low, high) laterally, at the height z.
IndexRange columnsAt(const JosephView& view, const DetectorColumnRun& run, int slice, double z, IndexRange between) {
    const auto at = [&](int n) { return view.rolled[std::size_t(n)].lateral(slice, z); };
    const bool ascending = at(run.columns.last - 1) >= at(run.columns.first);
    const auto firstNotBefore = [&](double limit) {
        int from = run.columns.first, to = run.columns.last;
        while (from < to) {
            const int middle = from + (to - from) / 2;
            (ascending ? at(middle) < limit : at(middle) > limit) ? from = middle + 1 : to = middle;
        }
        return from;
    };
    return {firstNotBefore(ascending ? between.first : between.last),
            firstNotBefore(ascending ? between.last : between.first)};
}

}  // namespace

void backprojectRolledDispatched(const ColumnVolume& layout, std::size_t block, const ViewRays& rays, float* values,
                                 float* weights) {
    const JosephView& view = rays.view;
    const Index3 dims = layout.lattice().dims;
    const ColumnRange range = layout.ranges()[block];
    Scratch scratch(view.height);
    scratch.taps.resize(std::size_t(3 * kLaneCount * RayImage::kMargin / 2));
    const RolledSums sums{layout, block, {values, weights}, scratch};
    for (const DetectorColumnRun& run : view.runs) {
        const int firstSlice = run.axis == 0 ? layout.firstX(block) : layout.firstY(block);
        const int firstLateral = run.axis == 0 ? layout.firstY(block) : layout.firstX(block);
        const int lastSlice = std::min(firstSlice + kBlockEdge, dims[run.axis]);
        for (int slice = firstSlice; slice < lastSlice; ++slice) {
            const IndexRange near{firstLateral - 1, firstLateral + kBlockEdge};
            const IndexRange low = columnsAt(view, run, slice, range.low - 1, near);
            const IndexRange high = columnsAt(view, run, slice, range.high, near);
            for (int n = std::min(low.first, high.first); n < std::max(low.last, high.last); ++n) {
                const RolledColumn& column = view.rolled[std::size_t(n)];
                if (slice < column.slices.first || slice >= column.slices.last) continue;
                sums.add(column, {rays.values.column(n), rays.weights.column(n)}, view.height, slice);
            }
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(backprojectRolledDispatched);

void backprojectRolled(const ColumnVolume& layout, std::size_t block, const ViewRays& rays, float* values,
                       float* weights) {
    HWY_DYNAMIC_DISPATCH(backprojectRolledDispatched)(layout, block, rays, values, weights);
}

}  // namespace raysweep
#endif  // HWY_ONCE
