// Volume to detector. Each task owns columns of the detector, so sums have one order whatever the number of threads.
#include "raysweep/projector/project.h"

#include "raysweep/core/parallel.h"
#include "raysweep/projector/oblique.h"

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
struct Beside {
    const float* voxels = nullptr;  ///< null: outside, or nothing is kept there
    float weight = 0;
    ColumnRange range;
};

/// The columns beside a fan's line, slice by slice.
class BesideLine {
  public:
    BesideLine(const ColumnVolume& volume, const FanLine& line)
        : volume_(volume), line_(line), lateralCount_(volume.lattice().dims[1 - line.axis]) {}

    void at(int slice, Beside (&beside)[2]) const {
        const double lateral = line_.lateral(slice);
        const int low = int(std::floor(lateral));
        const float upper = float(lateral - low);
        beside[0] = column(slice, low, 1 - upper);
        beside[1] = column(slice, low + 1, upper);
    }

    /// Asks for the columns of a slice to come.
    HWY_INLINE void prefetch(int slice) const {
        constexpr int kLine = 16;
        Beside beside[2];
        at(slice, beside);
        for (const Beside& b : beside)
            for (int z = 0; b.voxels && z < b.range.length(); z += kLine) hwy::Prefetch(b.voxels + z);
    }

  private:
    Beside column(int slice, int lateral, float weight) const {
        if (lateral < 0 || lateral >= lateralCount_) return {};
        const int x = line_.axis == 0 ? slice : lateral, y = line_.axis == 0 ? lateral : slice;
        const std::size_t tile = volume_.tileOf(x, y);
        const ColumnRange range = volume_.ranges()[tile];
        if (range.length() == 0) return {};
        return {volume_.column(tile, x, y), weight, range};
    }

    const ColumnVolume& volume_;
    const FanLine& line_;
    int lateralCount_;
};

constexpr int kAhead = 4;  ///< slices: how far ahead columns are asked for

/// One column of voxels with zeros around it, and how much of the two columns beside the ray it covers.
struct Scratch {
    explicit Scratch(int dimZ)
        : column(std::size_t(dimZ) + 2 * FanImage::kMargin + kColumnChunk), steps(std::size_t(dimZ) + 1) {}
    float* at(int z) { return column.data() + FanImage::kMargin + z; }

    std::vector<float> column;
    std::vector<float> steps;
};

/// All rays of the line stay at their z: they sum whole columns, and are interpolated once, at the end.
void projectLevel(const ColumnVolume& volume, const FanLine& line, int rowCount, Scratch& scratch, float* values,
                  float* weights) {
    std::fill(scratch.column.begin(), scratch.column.end(), 0.0f);
    std::fill(scratch.steps.begin(), scratch.steps.end(), 0.0f);
    const BesideLine columns(volume, line);
    const int dimZ = volume.lattice().dims.z;
    Beside beside[2];
    for (int slice = line.slices.first; slice < line.slices.last; ++slice) {
        if (slice + kAhead < line.slices.last) columns.prefetch(slice + kAhead);
        columns.at(slice, beside);
        for (const Beside& b : beside) {
            if (!b.voxels) continue;
            addScaled(scratch.at(b.range.low), b.voxels, b.weight, b.range.length());
            // The sum of weights changes where a column begins and behind where it ends.
            scratch.steps[std::size_t(b.range.low)] += b.weight;
            scratch.steps[std::size_t(std::min(b.range.high, dimZ))] -= b.weight;
        }
    }
    const RowPositions rows{line.height(0), line.pitch(0)};
    addInterpolated(scratch.at(0), 0, dimZ, rows, values, rowCount);
    float sum = 0;
    for (int z = 0; z < dimZ; ++z) *scratch.at(z) = sum += scratch.steps[std::size_t(z)];
    addInterpolated(scratch.at(0), 0, dimZ, rows, weights, rowCount);
}

/// The two columns of a slice, mixed: zeros around them included.
ColumnRange mix(const Beside (&beside)[2], Scratch& scratch) {
    ColumnRange both{1 << 30, 0};
    for (const Beside& b : beside)
        if (b.voxels) both = {std::min(both.low, b.range.low), std::max(both.high, b.range.high)};
    if (both.high == 0) return {};
    std::fill(scratch.at(both.low - kColumnChunk), scratch.at(both.high + kColumnChunk), 0.0f);
    for (const Beside& b : beside)
        if (b.voxels) addScaled(scratch.at(b.range.low), b.voxels, b.weight, b.range.length());
    return both;
}

/// Rays that rise or sink: every slice is interpolated at its own heights.
void projectUpright(const ColumnVolume& volume, const FanLine& line, int rowCount, Scratch& scratch, float* values,
                    float* weights) {
    const BesideLine columns(volume, line);
    const int dimZ = volume.lattice().dims.z;
    Beside beside[2];
    for (int slice = line.slices.first; slice < line.slices.last; ++slice) {
        columns.at(slice, beside);
        const ColumnRange both = mix(beside, scratch);
        if (both.length() == 0) continue;
        const RowPositions rows{line.height(slice), line.pitch(slice)};
        addInterpolated(scratch.at(0), both.low, std::min(both.high, dimZ), rows, values, rowCount);
        for (const Beside& b : beside)
            if (b.voxels) addCoverage(b.weight, b.range.low, std::min(b.range.high, dimZ), rows, weights, rowCount);
    }
}

}  // namespace

void projectLinesDispatched(const ColumnVolume& volume, int first, int last, ViewRays& rays) {
    const ViewFootprint& footprint = rays.footprint;
    Scratch scratch(volume.lattice().dims.z);
    for (int n = first; n < last; ++n) {
        const FanLine& line = footprint.lines[std::size_t(n)];
        float* values = rays.values.column(n);
        float* weights = rays.weights.column(n);
        const auto projectLine = footprint.kind == ViewFootprint::Kind::level ? projectLevel : projectUpright;
        projectLine(volume, line, footprint.height, scratch, values, weights);
        for (int v = 0; v < footprint.height; ++v) {
            const float length = line.length(v);
            values[v] *= length;
            weights[v] *= length;
        }
        std::fill(values + footprint.height, values + footprint.height + FanImage::kMargin, 0.0f);
        std::fill(weights + footprint.height, weights + footprint.height + FanImage::kMargin, 0.0f);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(projectLinesDispatched);

void aim(ViewRays& rays, const ProjectionGeometry& geometry, int view, const ColumnLattice& lattice) {
    rays.footprint = footprintOf(geometry, view, lattice);
    const bool level = rays.footprint.kind == ViewFootprint::Kind::level;
    rays.values.resize(geometry.width, geometry.height);
    rays.weights.resize(geometry.width, geometry.height);
    rays.levelValues.resize(level ? geometry.width : 0, lattice.dims.z);
    rays.levelWeights.resize(level ? geometry.width : 0, lattice.dims.z);
}

void projectView(const ColumnVolume& volume, ViewRays& rays) {
    const ViewFootprint& footprint = rays.footprint;
    // Neighbouring lines meet the same columns: they belong to one task.
    constexpr int kLines = 8;
    parallelFor(std::size_t((footprint.width + kLines - 1) / kLines), [&](std::size_t task) {
        const int first = int(task) * kLines, last = std::min(footprint.width, first + kLines);
        for (int n = first; n < last; ++n)
            for (FanImage* image : {&rays.values, &rays.weights})
                std::fill(image->column(n), image->column(n) + footprint.height, 0.0f);
        if (footprint.kind == ViewFootprint::Kind::oblique)
            projectOblique(volume, first, last, rays);
        else
            HWY_DYNAMIC_DISPATCH(projectLinesDispatched)(volume, first, last, rays);
    });
}

}  // namespace raysweep
#endif  // HWY_ONCE
