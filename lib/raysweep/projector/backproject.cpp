// Backprojection, Aᵀ y (joseph.h, eq. 1): detector to volume. Each task owns a block of columns and looks up which rays
// meet it, so no two write to the same voxel and sums have one order whatever the number of threads.
#include "raysweep/projector/backproject.h"

#include "raysweep/core/parallel.h"
#include "raysweep/projector/oblique.h"
#include "raysweep/projector/rolled.h"

#include <algorithm>
#include <cstring>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/backproject.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/column_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// Detector columns of `run` whose lateral position in `slice` lies in (low, high).
IndexRange columnsBetween(const JosephView& view, const DetectorColumnRun& run, int slice, double low, double high) {
    const auto at = [&](int n) { return view.columns[std::size_t(n)].lateral(slice); };
    const bool ascending = at(run.columns.last - 1) >= at(run.columns.first);
    // The first that is not before `limit`, in the sense in which they follow each other.
    const auto firstNotBefore = [&](double limit) {
        int from = run.columns.first, to = run.columns.last;
        while (from < to) {
            const int middle = from + (to - from) / 2;
            (ascending ? at(middle) < limit : at(middle) > limit) ? from = middle + 1 : to = middle;
        }
        return from;
    };
    return {firstNotBefore(ascending ? low : high), firstNotBefore(ascending ? high : low)};
}

struct BlockSums {
    const ColumnVolume& layout;
    int firstX, firstY;
    ColumnRange range;
    ValuesAndWeights<float> sums;

    /// Gives a column of numbers, low to high, to column (x,y), if that belongs to the block and the volume.
    HWY_INLINE void add(int x, int y, float weight, ValuesAndWeights<const float> column) const {
        if (x < firstX || y < firstY || x >= std::min(firstX + kBlockEdge, layout.lattice().dims.x) ||
            y >= std::min(firstY + kBlockEdge, layout.lattice().dims.y))
            return;
        const std::size_t offset = std::size_t((x - firstX) * kBlockEdge + y - firstY) * range.length();
        addScaled(sums.values + offset, column.values, weight, range.length());
        addScaled(sums.weights + offset, column.weights, weight, range.length());
    }
};

/// Numbers of detector column n at the voxels' z in `slice`, from the block's lowest voxel on. `scratch`: room for
/// them.
HWY_INLINE ValuesAndWeights<const float> atVoxels(const BlockSums& block, const ViewRays& rays, int n, int slice,
                                                  ValuesAndWeights<float> scratch) {
    const ColumnRange range = block.range;
    if (rays.view.kind == JosephView::Kind::level)
        return {rays.levelValues.column(n) + range.low, rays.levelWeights.column(n) + range.low};
    gatherRows({rays.values.column(n), rays.weights.column(n)}, rays.view.columns[std::size_t(n)].rows(slice), range,
               scratch);
    for (int z = block.layout.lattice().dims.z; z < range.high; ++z) scratch.values[z] = scratch.weights[z] = 0;
    return {scratch.values + range.low, scratch.weights + range.low};
}

void addView(const BlockSums& block, const ViewRays& rays, ValuesAndWeights<float> scratch) {
    const JosephView& view = rays.view;
    const Index3 dims = block.layout.lattice().dims;
    for (const DetectorColumnRun& run : view.runs) {
        const int firstSlice = run.axis == 0 ? block.firstX : block.firstY;
        const int firstLateral = run.axis == 0 ? block.firstY : block.firstX;
        const int lastSlice = std::min(firstSlice + kBlockEdge, dims[run.axis]);
        for (int slice = firstSlice; slice < lastSlice; ++slice) {
            const IndexRange met = columnsBetween(view, run, slice, firstLateral - 1, firstLateral + kBlockEdge);
            for (int n = met.first; n < met.last; ++n) {
                const DetectorColumn& column = view.columns[std::size_t(n)];
                if (slice < column.slices.first || slice >= column.slices.last) continue;
                const LateralWeights w = column.beside(slice);
                const ValuesAndWeights<const float> numbers = atVoxels(block, rays, n, slice, scratch);
                block.add(column.voxelX(slice, w.below), column.voxelY(slice, w.below), w.lower, numbers);
                block.add(column.voxelX(slice, w.below + 1), column.voxelY(slice, w.below + 1), w.upper, numbers);
            }
        }
    }
}

}  // namespace

void backprojectBlockDispatched(const ColumnVolume& layout, std::size_t b, const std::vector<ViewRays>& views,
                                float* values, float* weights) {
    const BlockSums block{layout, layout.firstX(b), layout.firstY(b), layout.ranges()[b], {values, weights}};
    const std::size_t room = std::size_t(layout.lattice().dims.z + kColumnChunk);
    std::vector<float> scratch(2 * room);
    for (const ViewRays& rays : views) {
        if (rays.view.kind == JosephView::Kind::oblique)
            backprojectOblique(layout, b, rays, values, weights);
        else if (rays.view.kind == JosephView::Kind::rolled)
            backprojectRolled(layout, b, rays, values, weights);
        else
            addView(block, rays, {scratch.data(), scratch.data() + room});
    }
}

/// Brings the rows of level rays to the voxels' z, once for all slices.
void levelColumnsDispatched(ViewRays& rays, IndexRange columns, int dimZ) {
    const int high = (dimZ + kColumnChunk - 1) / kColumnChunk * kColumnChunk;
    for (int n = columns.first; n < columns.last; ++n) {
        float *values = rays.levelValues.column(n), *weights = rays.levelWeights.column(n);
        gatherRows({rays.values.column(n), rays.weights.column(n)}, rays.view.columns[std::size_t(n)].rows(0),
                   {0, high}, {values, weights});
        std::fill(values + dimZ, values + high, 0.0f);
        std::fill(weights + dimZ, weights + high, 0.0f);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(backprojectBlockDispatched);
HWY_EXPORT(levelColumnsDispatched);

void prepareBackprojection(ViewRays& rays, int dimZ) {
    const JosephView& view = rays.view;
    if (view.kind == JosephView::Kind::oblique) return;  // their lengths are found on the way
    const bool rolled = view.kind == JosephView::Kind::rolled;
    constexpr int kTogether = 32;
    parallelFor(std::size_t((view.width + kTogether - 1) / kTogether), [&](std::size_t task) {
        const int first = int(task) * kTogether;
        const IndexRange columns{first, std::min(view.width, first + kTogether)};
        for (int n = columns.first; n < columns.last; ++n)
            for (int v = 0; v < view.height; ++v) {
                const float length =
                    rolled ? view.rolled[std::size_t(n)].length(v) : view.columns[std::size_t(n)].length(v);
                rays.values.column(n)[v] *= length;
                rays.weights.column(n)[v] *= length;
            }
        if (view.kind == JosephView::Kind::level) HWY_DYNAMIC_DISPATCH(levelColumnsDispatched)(rays, columns, dimZ);
    });
}

void backprojectBlock(const ColumnVolume& layout, std::size_t block, const std::vector<ViewRays>& views, float* values,
                      float* weights) {
    const std::size_t count = layout.voxelsOf(block);
    if (count == 0) return;
    std::memset(values, 0, count * sizeof(float));
    std::memset(weights, 0, count * sizeof(float));
    HWY_DYNAMIC_DISPATCH(backprojectBlockDispatched)(layout, block, views, values, weights);
}

void backprojectView(ViewRays& rays, ColumnVolume& to) {
    prepareBackprojection(rays, to.lattice().dims.z);
    std::vector<ViewRays> views;
    views.push_back(std::move(rays));  // braces would copy
    parallelFor(to.blockCount(), [&](std::size_t b) {
        std::vector<float> weights(to.voxelsOf(b));
        backprojectBlock(to, b, views, to.block(b), weights.data());
    });
}

}  // namespace raysweep
#endif  // HWY_ONCE
