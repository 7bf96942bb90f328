// From voxels to rays: whole vectors of rows. Compiled once per instruction set.
#include "raysweep/projector/rolled.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/project_rolled.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/rolled_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

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

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(projectRolledDispatched);

void projectRolled(const ColumnVolume& volume, IndexRange columns, ViewRays& rays) {
    HWY_DYNAMIC_DISPATCH(projectRolledDispatched)(volume, columns, rays);
}

}  // namespace raysweep
#endif  // HWY_ONCE
