#include "raysweep/projector/rolled.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/rolled.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/column_kernels-inl.h"

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

/// A vector of rows where they cross columns of voxels of one range.
struct RowsInRange {
    Vec upper;      ///< weight of the voxel above, 1 - upper that of the one below
    Vec coverage;   ///< sum of the weights of the voxels that there are
    int base;       ///< voxel below the first lane's row
    IntVec behind;  ///< of the others
    bool isNear;
    Lookup ofBelow, ofAbove;
    Vec below;        ///< the voxels below
    float low, high;  ///< range
    bool isInside;    ///< all those voxels are there

    /// @param first,last z of the outermost lanes
    HWY_INLINE RowsInRange(Vec z, float first, float last, ColumnRange range, int dimZ)
        : RowsInRange(z, besideRays(clamped(z, range)), first, last, range, dimZ) {}

    /// @param voxels the column's voxel of z = 0, kept or not
    HWY_INLINE Vec valueOf(const float* voxels) const {
        Vec here, next;
        if (isNear) {
            const Nearby column(voxels + base);
            here = column[ofBelow];
            next = column[ofAbove];
        } else {
            here = hn::GatherIndex(kLanes, voxels + base, behind);
            next = hn::GatherIndex(kLanes, voxels + base + 1, behind);
        }
        if (!isInside) {
            const Vec first = hn::Set(kLanes, low), end = hn::Set(kLanes, high);
            const Vec above = hn::Add(below, hn::Set(kLanes, 1.0f));
            here = hn::IfThenElseZero(hn::And(hn::Ge(below, first), hn::Lt(below, end)), here);
            next = hn::IfThenElseZero(hn::And(hn::Ge(above, first), hn::Lt(above, end)), next);
        }
        return hn::MulAdd(upper, hn::Sub(next, here), here);
    }

  private:
    static HWY_INLINE Vec clamped(Vec z, ColumnRange range) {
        return hn::Min(hn::Max(z, hn::Set(kLanes, float(range.low - 1))), hn::Set(kLanes, float(range.high)));
    }

    HWY_INLINE RowsInRange(Vec z, LaneWeights at, float first, float last, ColumnRange range, int dimZ)
        : RowsInRange(z, at, hn::ConvertTo(kIntLanes, at.below), first, last, range, dimZ) {}

    HWY_INLINE RowsInRange(Vec z, LaneWeights at, IntVec index, float first, float last, ColumnRange range, int dimZ)
        : upper(at.upper),
          coverage(weightBetween(z, hn::Set(kLanes, float(range.low - 1)),
                                 hn::Set(kLanes, float(std::min(range.high, dimZ))))),
          base(hn::GetLane(index)),
          behind(hn::Sub(index, hn::Set(kIntLanes, base))),
          isNear(Nearby::reaches(int(std::min(last, float(range.high)) - std::max(first, float(range.low - 1))) + 2)),
          ofBelow(behind),
          ofAbove(hn::Add(behind, hn::Set(kIntLanes, 1))),
          below(at.below),
          low(float(range.low)),
          high(float(range.high)) {
        constexpr float kRounding = 0.01f;
        isInside = first >= low + kRounding && last < high - 1 - kRounding;
    }
};

/// A column of voxels.
struct StoredColumn {
    const float* voxels;  ///< that of z = 0, kept or not
    ColumnRange range;
};

/// The rays of a detector column in a slice, and the columns of voxels beside them.
class RowsInSlice {
  public:
    RowsInSlice(const ColumnVolume& volume, int rowCount)
        : volume_(volume), rowCount_(rowCount), heights_(std::size_t(rowCount + kLaneCount)) {}

    void project(const RolledColumn& column, int slice, ValuesAndWeights<float> to) {
        const int dimZ = volume_.lattice().dims.z;
        rows_ = column.rows(slice);
        const IndexRange met = rowsBetween(rows_, -1, float(dimZ), rowCount_);
        if (met.first == met.last) return;
        for (int v = met.first; v < met.last; v += kLaneCount) hn::StoreU(heightsFrom(rows_, v), kLanes, &heights_[v]);
        // Lanes behind the last row, whose z may be anywhere, must not widen what a vector of rows is taken to meet.
        std::fill_n(&heights_[rowCount_], kLaneCount, rows_.at(float(rowCount_ - 1)));
        findColumns(column, slice, heightsOf(met));
        for (int v = met.first; v < met.last; v += kLaneCount)
            addColumns(v, besideRows({v, v + kLaneCount}), {to.values + v, to.weights + v});
    }

  private:
    struct Heights {
        float low, high;
    };
    Heights heightsOf(IndexRange rows) const {
        return {std::max(heights_[rows.first], -1.0f),
                std::min(heights_[rows.last - 1], float(volume_.lattice().dims.z))};
    }
    IndexRange besideRows(IndexRange rows) const {
        const Heights z = heightsOf(rows);
        return beside(rows_, z.low, z.high, columns_);
    }

    void findColumns(const RolledColumn& column, int slice, Heights z) {
        columns_ = beside(rows_, z.low, z.high, {0, volume_.lattice().dims[1 - column.axis]});
        stored_.clear();
        for (int j = columns_.first; j < columns_.last; ++j) {
            const int x = column.voxelX(slice, j), y = column.voxelY(slice, j);
            const std::size_t block = volume_.blockOf(x, y);
            const ColumnRange range = volume_.ranges()[block];
            stored_.push_back({volume_.column(block, x, y) - range.low, range});
        }
    }

    HWY_INLINE void addColumns(int v, IndexRange columns, ValuesAndWeights<float> to) const {
        const Vec z = hn::LoadU(kLanes, &heights_[v]), lateral = lateralAt(rows_, z);
        const float first = heights_[v], last = heights_[v + kLaneCount - 1];
        Vec values = hn::LoadU(kLanes, to.values), weights = hn::LoadU(kLanes, to.weights);
        for (int j = columns.first; j < columns.last;) {
            const ColumnRange range = at(j).range;
            if (range.length() == 0) {
                ++j;
                continue;
            }
            const RowsInRange rows(z, first, last, range, volume_.lattice().dims.z);
            do {
                const Vec w = weightAt(hn::Sub(lateral, hn::Set(kLanes, float(j))));
                values = hn::MulAdd(w, rows.valueOf(at(j).voxels), values);
                weights = hn::MulAdd(w, rows.coverage, weights);
            } while (++j < columns.last && at(j).range.low == range.low && at(j).range.high == range.high);
        }
        hn::StoreU(values, kLanes, to.values);
        hn::StoreU(weights, kLanes, to.weights);
    }
    const StoredColumn& at(int j) const { return stored_[std::size_t(j - columns_.first)]; }

    const ColumnVolume& volume_;
    int rowCount_;
    LeaningRows rows_{};
    std::vector<float> heights_;  ///< z of each row
    IndexRange columns_;
    std::vector<StoredColumn> stored_;  ///< of `columns_`
};

/// Those of the detector columns whose major axis this is, slice by slice: neighbours read mostly the same of one,
/// which is near then.
void addSlices(RowsInSlice& rows, int axis, int slices, IndexRange columns, ViewRays& rays) {
    for (int slice = 0; slice < slices; ++slice)
        for (int n = columns.first; n < columns.last; ++n) {
            const RolledColumn& column = rays.view.rolled[std::size_t(n)];
            if (column.axis == axis && slice >= column.slices.first && slice < column.slices.last)
                rows.project(column, slice, {rays.values.column(n), rays.weights.column(n)});
        }
}

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

void projectRolledDispatched(const ColumnVolume& volume, IndexRange columns, ViewRays& rays) {
    const JosephView& view = rays.view;
    RowsInSlice rows(volume, view.height);
    for (int axis = 0; axis < 2; ++axis) addSlices(rows, axis, volume.lattice().dims[axis], columns, rays);
    for (int n = columns.first; n < columns.last; ++n) {
        const RolledColumn& column = view.rolled[std::size_t(n)];
        float *values = rays.values.column(n), *weights = rays.weights.column(n);
        for (int v = 0; v < view.height; ++v) {
            const float length = column.length(v);
            values[v] *= length;
            weights[v] *= length;
        }
        std::fill(values + view.height, values + view.height + RayImage::kMargin, 0.0f);
        std::fill(weights + view.height, weights + view.height + RayImage::kMargin, 0.0f);
    }
}

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

HWY_EXPORT(projectRolledDispatched);
HWY_EXPORT(backprojectRolledDispatched);

void projectRolled(const ColumnVolume& volume, IndexRange columns, ViewRays& rays) {
    HWY_DYNAMIC_DISPATCH(projectRolledDispatched)(volume, columns, rays);
}

void backprojectRolled(const ColumnVolume& layout, std::size_t block, const ViewRays& rays, float* values,
                       float* weights) {
    HWY_DYNAMIC_DISPATCH(backprojectRolledDispatched)(layout, block, rays, values, weights);
}

}  // namespace raysweep
#endif  // HWY_ONCE
