// Forward projection, p = A x (joseph.h, eq. 1): volume to detector. Each task owns columns of the detector, so sums
// have one order whatever the number of threads.
#include "raysweep/projector/project.h"

#include "raysweep/core/parallel.h"
#include "raysweep/projector/oblique.h"
#include "raysweep/projector/rolled.h"

#include <hwy/cache_control.h>

#include <vector>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/projector/project.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raysweep/projector/column_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

/// A column of voxels beside a ray, and the ray's weight for it.
struct WeightedColumn {
    const float* voxels = nullptr;  ///< null: outside, or nothing is kept there
    float weight = 0;
    ColumnRange range;
};

/// The two columns of voxels beside the rays of a detector column, slice by slice.
class ColumnsBeside {
  public:
    ColumnsBeside(const ColumnVolume& volume, const DetectorColumn& rays)
        : volume_(volume), rays_(rays), lateralCount_(volume.lattice().dims[1 - rays.axis]) {}

    void at(int slice, WeightedColumn (&beside)[2]) const {
        const LateralWeights w = rays_.beside(slice);
        beside[0] = column(slice, w.below, w.lower);
        beside[1] = column(slice, w.below + 1, w.upper);
    }

    /// Asks for the columns of a slice to come.
    HWY_INLINE void prefetch(int slice) const {
        constexpr int kLine = 16;
        WeightedColumn beside[2];
        at(slice, beside);
        for (const WeightedColumn& b : beside)
            for (int z = 0; b.voxels && z < b.range.length(); z += kLine) hwy::Prefetch(b.voxels + z);
    }

  private:
    WeightedColumn column(int slice, int lateral, float weight) const {
        if (lateral < 0 || lateral >= lateralCount_) return {};
        const int x = rays_.voxelX(slice, lateral), y = rays_.voxelY(slice, lateral);
        const std::size_t block = volume_.blockOf(x, y);
        const ColumnRange range = volume_.ranges()[block];
        if (range.length() == 0) return {};
        return {volume_.column(block, x, y), weight, range};
    }

    const ColumnVolume& volume_;
    const DetectorColumn& rays_;
    int lateralCount_;
};

constexpr int kAhead = 4;  ///< slices: how far ahead columns are asked for

/// One column of voxels with zeros around it, and how much of the two columns beside the ray it covers.
struct Scratch {
    explicit Scratch(int dimZ)
        : column(std::size_t(dimZ) + 2 * RayImage::kMargin + kColumnChunk), jumps(std::size_t(dimZ) + 1) {}
    float* at(int z) { return column.data() + RayImage::kMargin + z; }

    std::vector<float> column;
    std::vector<float> jumps;
};

/// All rays of the detector column stay at their z: they sum whole columns, and are interpolated once, at the end.
void projectLevel(const ColumnVolume& volume, const DetectorColumn& rays, Scratch& scratch,
                  ValuesAndWeights<float> to) {
    std::fill(scratch.column.begin(), scratch.column.end(), 0.0f);
    std::fill(scratch.jumps.begin(), scratch.jumps.end(), 0.0f);
    const ColumnsBeside columns(volume, rays);
    const int dimZ = volume.lattice().dims.z;
    WeightedColumn beside[2];
    for (int slice = rays.slices.first; slice < rays.slices.last; ++slice) {
        if (slice + kAhead < rays.slices.last) columns.prefetch(slice + kAhead);
        columns.at(slice, beside);
        for (const WeightedColumn& b : beside) {
            if (!b.voxels) continue;
            addScaled(scratch.at(b.range.low), b.voxels, b.weight, b.range.length());
            // The sum of weights changes where a column begins and behind where it ends.
            scratch.jumps[std::size_t(b.range.low)] += b.weight;
            scratch.jumps[std::size_t(std::min(b.range.high, dimZ))] -= b.weight;
        }
    }
    const DetectorRows rows = rays.rows(0);
    addInterpolated(scratch.at(0), {0, dimZ}, rows, to.values);
    float sum = 0;
    for (int z = 0; z < dimZ; ++z) *scratch.at(z) = sum += scratch.jumps[std::size_t(z)];
    addInterpolated(scratch.at(0), {0, dimZ}, rows, to.weights);
}

/// The two columns of a slice, mixed: zeros around them included.
ColumnRange mix(const WeightedColumn (&beside)[2], Scratch& scratch) {
    ColumnRange both{1 << 30, 0};
    for (const WeightedColumn& b : beside)
        if (b.voxels) both = {std::min(both.low, b.range.low), std::max(both.high, b.range.high)};
    if (both.high == 0) return {};
    std::fill(scratch.at(both.low - kColumnChunk), scratch.at(both.high + kColumnChunk), 0.0f);
    for (const WeightedColumn& b : beside)
        if (b.voxels) addScaled(scratch.at(b.range.low), b.voxels, b.weight, b.range.length());
    return both;
}

/// Rays that rise or sink: every slice is interpolated at its own heights.
void projectUpright(const ColumnVolume& volume, const DetectorColumn& rays, Scratch& scratch,
                    ValuesAndWeights<float> to) {
    const ColumnsBeside columns(volume, rays);
    const int dimZ = volume.lattice().dims.z;
    WeightedColumn beside[2];
    for (int slice = rays.slices.first; slice < rays.slices.last; ++slice) {
        columns.at(slice, beside);
        const ColumnRange both = mix(beside, scratch);
        if (both.length() == 0) continue;
        const DetectorRows rows = rays.rows(slice);
        addInterpolated(scratch.at(0), {both.low, std::min(both.high, dimZ)}, rows, to.values);
        for (const WeightedColumn& b : beside)
            if (b.voxels) addCoverage(b.weight, {b.range.low, std::min(b.range.high, dimZ)}, rows, to.weights);
    }
}

}  // namespace

void projectColumnsDispatched(const ColumnVolume& volume, IndexRange columns, ViewRays& rays) {
    const JosephView& view = rays.view;
    Scratch scratch(volume.lattice().dims.z);
    for (int n = columns.first; n < columns.last; ++n) {
        const DetectorColumn& column = view.columns[std::size_t(n)];
        float* values = rays.values.column(n);
        float* weights = rays.weights.column(n);
        const auto project = view.kind == JosephView::Kind::level ? projectLevel : projectUpright;
        project(volume, column, scratch, {values, weights});
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

HWY_EXPORT(projectColumnsDispatched);

void setView(ViewRays& rays, const ProjectionGeometry& geometry, int number, const ColumnLattice& lattice) {
    rays.view = josephView(geometry, number, lattice);
    const bool level = rays.view.kind == JosephView::Kind::level;
    const int width = rays.view.width, height = rays.view.height;
    rays.values.resize(width, height);
    rays.weights.resize(width, height);
    rays.levelValues.resize(level ? width : 0, lattice.dims.z);
    rays.levelWeights.resize(level ? width : 0, lattice.dims.z);
}

void projectView(const ColumnVolume& volume, ViewRays& rays) {
    const JosephView& view = rays.view;
    // Neighbouring detector columns meet the same columns of voxels: they belong to one task.
    constexpr int kTogether = 8;
    parallelFor(std::size_t((view.width + kTogether - 1) / kTogether), [&](std::size_t task) {
        const int first = int(task) * kTogether;
        const IndexRange columns{first, std::min(view.width, first + kTogether)};
        for (int n = columns.first; n < columns.last; ++n)
            for (RayImage* image : {&rays.values, &rays.weights})
                std::fill(image->column(n), image->column(n) + view.height, 0.0f);
        if (view.kind == JosephView::Kind::oblique)
            projectOblique(volume, columns, rays);
        else if (view.kind == JosephView::Kind::rolled)
            projectRolled(volume, columns, rays);
        else
            HWY_DYNAMIC_DISPATCH(projectColumnsDispatched)(volume, columns, rays);
    });
}

}  // namespace raysweep
#endif  // HWY_ONCE
