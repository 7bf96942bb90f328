// Detector to volume. Each task owns a tile and looks up which rays meet it, so no two write to the same voxel and sums
// have one order whatever the number of threads.
#include "raysweep/projector/backproject.h"

#include "raysweep/core/parallel.h"
#include "raysweep/projector/oblique.h"

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

/// Lines of `run` whose lateral position in `slice` lies in (low, high).
SliceRange linesBetween(const ViewFootprint& f, const FanRun& run, int slice, double low, double high) {
    const auto at = [&](int n) { return f.lines[std::size_t(n)].lateral(slice); };
    const bool ascending = at(run.last - 1) >= at(run.first);
    // The first line that is not before `limit`, in the sense in which lines follow each other.
    const auto firstNotBefore = [&](double limit) {
        int from = run.first, to = run.last;
        while (from < to) {
            const int middle = from + (to - from) / 2;
            (ascending ? at(middle) < limit : at(middle) > limit) ? from = middle + 1 : to = middle;
        }
        return from;
    };
    return {firstNotBefore(ascending ? low : high), firstNotBefore(ascending ? high : low)};
}

struct TileSums {
    const ColumnVolume& layout;
    int firstX, firstY;
    ColumnRange range;
    float *values, *weights;

    /// Gives a column of numbers, low to high, to column (x,y), if that belongs to the tile and the volume.
    HWY_INLINE void add(int x, int y, float weight, const float* value, const float* rayWeight) const {
        if (x < firstX || y < firstY || x >= std::min(firstX + kTileEdge, layout.lattice().dims.x) ||
            y >= std::min(firstY + kTileEdge, layout.lattice().dims.y))
            return;
        const std::size_t offset = std::size_t((x - firstX) * kTileEdge + y - firstY) * range.length();
        addScaled(values + offset, value, weight, range.length());
        addScaled(weights + offset, rayWeight, weight, range.length());
    }
};

void addView(const TileSums& tile, const ViewRays& rays, float* scratch) {
    const ViewFootprint& f = rays.footprint;
    const Index3 dims = tile.layout.lattice().dims;
    const bool level = f.kind == ViewFootprint::Kind::level;
    const ColumnRange range = tile.range;
    float *columnValues = scratch, *columnWeights = scratch + dims.z + kColumnChunk;
    for (const FanRun& run : f.runs) {
        const int firstSlice = run.axis == 0 ? tile.firstX : tile.firstY;
        const int firstLateral = run.axis == 0 ? tile.firstY : tile.firstX;
        const int lastSlice = std::min(firstSlice + kTileEdge, dims[run.axis]);
        for (int slice = firstSlice; slice < lastSlice; ++slice) {
            const SliceRange lines = linesBetween(f, run, slice, firstLateral - 1, firstLateral + kTileEdge);
            for (int n = lines.first; n < lines.last; ++n) {
                const FanLine& line = f.lines[std::size_t(n)];
                if (slice < line.slices.first || slice >= line.slices.last) continue;
                const double lateral = line.lateral(slice);
                const int below = int(std::floor(lateral));
                const float upper = float(lateral - below);
                const float *value = columnValues + range.low, *weight = columnWeights + range.low;
                if (level) {
                    value = rays.levelValues.column(n) + range.low;
                    weight = rays.levelWeights.column(n) + range.low;
                } else {
                    gatherRows(rays.values.column(n), rays.weights.column(n), f.height,
                               RowPositions{line.height(slice), line.pitch(slice)}, columnValues, columnWeights,
                               range.low, range.high);
                    for (int z = dims.z; z < range.high; ++z) columnValues[z] = columnWeights[z] = 0;
                }
                const int x = run.axis == 0 ? slice : below, y = run.axis == 0 ? below : slice;
                tile.add(x, y, 1 - upper, value, weight);
                tile.add(run.axis == 0 ? x : x + 1, run.axis == 0 ? y + 1 : y, upper, value, weight);
            }
        }
    }
}

}  // namespace

void backprojectTileDispatched(const ColumnVolume& layout, std::size_t t, const std::vector<ViewRays>& views,
                               float* values, float* weights) {
    const TileSums tile{layout,
                        int(t / std::size_t(layout.tilesY())) * kTileEdge,
                        int(t % std::size_t(layout.tilesY())) * kTileEdge,
                        layout.ranges()[t],
                        values,
                        weights};
    std::vector<float> scratch(2 * std::size_t(layout.lattice().dims.z + kColumnChunk));
    for (const ViewRays& view : views)
        view.footprint.kind == ViewFootprint::Kind::oblique ? backprojectOblique(layout, t, view, values, weights)
                                                            : addView(tile, view, scratch.data());
}

/// Brings the rows of level rays to the voxels' z, once for all slices.
void levelLinesDispatched(ViewRays& rays, int first, int last, int dimZ) {
    const int high = (dimZ + kColumnChunk - 1) / kColumnChunk * kColumnChunk;
    for (int n = first; n < last; ++n) {
        const FanLine& line = rays.footprint.lines[std::size_t(n)];
        float *values = rays.levelValues.column(n), *weights = rays.levelWeights.column(n);
        gatherRows(rays.values.column(n), rays.weights.column(n), rays.footprint.height,
                   RowPositions{line.height(0), line.pitch(0)}, values, weights, 0, high);
        std::fill(values + dimZ, values + high, 0.0f);
        std::fill(weights + dimZ, weights + high, 0.0f);
    }
}

void updateVoxelsDispatched(float* HWY_RESTRICT voxels, const float* HWY_RESTRICT values,
                            const float* HWY_RESTRICT weights, std::size_t count, const VoxelUpdate& update) {
    const Vec relaxation = hn::Set(kLanes, update.relaxation);
    const Vec lower = hn::Set(kLanes, update.lower), upper = hn::Set(kLanes, update.upper);
    const Vec zero = hn::Zero(kLanes), one = hn::Set(kLanes, 1.0f);
    for (std::size_t i = 0; i < count; i += std::size_t(kLaneCount)) {
        const Vec weight = hn::LoadU(kLanes, weights + i), before = hn::Load(kLanes, voxels + i);
        const auto met = hn::Gt(weight, zero);
        const Vec mean = hn::Div(hn::LoadU(kLanes, values + i), hn::IfThenElse(met, weight, one));
        const Vec after = hn::Min(hn::Max(hn::MulAdd(relaxation, mean, before), lower), upper);
        hn::Store(hn::IfThenElse(met, after, before), kLanes, voxels + i);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(backprojectTileDispatched);
HWY_EXPORT(levelLinesDispatched);
HWY_EXPORT(updateVoxelsDispatched);

void readyRays(ViewRays& rays, int dimZ) {
    const ViewFootprint& f = rays.footprint;
    if (f.kind == ViewFootprint::Kind::oblique) return;  // their lengths are found on the way
    constexpr int kLines = 32;
    parallelFor(std::size_t((f.width + kLines - 1) / kLines), [&](std::size_t task) {
        const int first = int(task) * kLines, last = std::min(f.width, first + kLines);
        for (int n = first; n < last; ++n)
            for (int v = 0; v < f.height; ++v) {
                const float length = f.lines[std::size_t(n)].length(v);
                rays.values.column(n)[v] *= length;
                rays.weights.column(n)[v] *= length;
            }
        if (f.kind == ViewFootprint::Kind::level) HWY_DYNAMIC_DISPATCH(levelLinesDispatched)(rays, first, last, dimZ);
    });
}

void backprojectTile(const ColumnVolume& layout, std::size_t tile, const std::vector<ViewRays>& views, float* values,
                     float* weights) {
    const std::size_t count = layout.voxelsOf(tile);
    if (count == 0) return;
    std::memset(values, 0, count * sizeof(float));
    std::memset(weights, 0, count * sizeof(float));
    HWY_DYNAMIC_DISPATCH(backprojectTileDispatched)(layout, tile, views, values, weights);
}

void backprojectView(ViewRays& rays, ColumnVolume& to) {
    readyRays(rays, to.lattice().dims.z);
    const std::vector<ViewRays> views{std::move(rays)};
    parallelFor(to.tileCount(), [&](std::size_t t) {
        std::vector<float> weights(to.voxelsOf(t));
        backprojectTile(to, t, views, to.tile(t), weights.data());
    });
}

void updateVoxels(float* voxels, const float* values, const float* weights, std::size_t count,
                  const VoxelUpdate& update) {
    HWY_DYNAMIC_DISPATCH(updateVoxelsDispatched)(voxels, values, weights, count, update);
}

}  // namespace raysweep
#endif  // HWY_ONCE
