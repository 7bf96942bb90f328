// Voxel-driven backprojection in whole vectors of voxels that lie above each other.
#include "raysweep/reconstruct/filtered_views.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>

#include "raysweep/core/simd_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raysweep/reconstruct/filtered_views.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace raysweep {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<float, kFbpChunk>;
using IntLanes = hn::RebindToSigned<Lanes>;
using Vec = hn::Vec<Lanes>;
using IntVec = hn::Vec<IntLanes>;
constexpr Lanes kLanes;
constexpr IntLanes kIntLanes;
constexpr int kLaneCount = int(hn::MaxLanes(kLanes));

/// A number that changes evenly from voxel to voxel of a column.
struct Progression {
    float first, step;
    HWY_INLINE Vec from(int k) const {
        return hn::MulAdd(hn::Iota(kLanes, float(k)), hn::Set(kLanes, step), hn::Set(kLanes, first));
    }
};

/// `count` voxels one above the other, and where a view sees them.
struct VoxelColumn {
    Progression x, y, depth;  ///< see ViewMatrix
    int count;

    VoxelColumn(const ViewMatrix& matrix, const Vec3& first, double spacing, int axis, int count)
        : x(along(matrix.x, first, spacing, axis)),
          y(along(matrix.y, first, spacing, axis)),
          depth(along(matrix.depth, first, spacing, axis)),
          count(count) {}

    /// All on one column of the detector, at one depth: to a thousandth of a pixel.
    bool isUpright() const {
        const float n = float(count);
        return std::abs(x.step) * n < 1e-3f * depth.first && std::abs(depth.step) * n < 1e-6f * depth.first;
    }

  private:
    static Progression along(const ViewMatrix::Affine& f, const Vec3& first, double spacing, int axis) {
        return {float(f(first)), float(f.a[axis] * spacing)};
    }
};

/// Place on a detector of `size` pixels as one in the rim's count; beside the detector it becomes the rim's edge.
HWY_INLINE Vec inRim(Vec place, int size) {
    return hn::Min(hn::Max(hn::Add(place, hn::Set(kLanes, 1.0f)), hn::Zero(kLanes)), hn::Set(kLanes, float(size + 1)));
}

/// Steps for which the rows beside the voxels of a vector lie within two vectors of rows.
bool fitsTables(float step) {
    return kLaneCount > 1 && step >= 0 && step * float(kLaneCount - 1) <= float(2 * kLaneCount - 3);
}

/// What two vectors, one behind the other, hold at places less than twice the lanes.
HWY_INLINE Vec lookup(Vec low, Vec high, IntVec place) {
    const auto index = hn::IndicesFromVec(kLanes, hn::And(place, hn::Set(kIntLanes, kLaneCount - 1)));
    const auto isLow = hn::RebindMask(kLanes, hn::Lt(place, hn::Set(kIntLanes, kLaneCount)));
    return hn::IfThenElse(isLow, hn::TableLookupLanes(low, index), hn::TableLookupLanes(high, index));
}

/// Adds what a view shows to a column of voxels: a term of eq. 3 or 4.
void addTilted(const FilteredView& view, const float* pixels, const VoxelColumn& voxels, float* sums) {
    const IntVec stride = hn::Set(kIntLanes, int(view.stride));
    const Vec least = hn::Set(kLanes, 1e-7f);  // voxels are further away, but not all beyond the column's end are
    for (int k = 0; k < voxels.count; k += kLaneCount) {
        const Vec inverse = hn::Div(hn::Set(kLanes, 1.0f), hn::Max(voxels.depth.from(k), least));
        const Vec u = inRim(hn::Mul(voxels.x.from(k), inverse), view.width);
        const Vec v = inRim(hn::Mul(voxels.y.from(k), inverse), view.height);
        const Vec column = hn::Floor(u), row = hn::Floor(v);
        const Vec fu = hn::Sub(u, column), fv = hn::Sub(v, row);
        const IntVec at = hn::Add(hn::Mul(hn::ConvertTo(kIntLanes, column), stride), hn::ConvertTo(kIntLanes, row));
        const auto blend = [&](const float* from) {
            const Vec here = hn::GatherIndex(kLanes, from, at), next = hn::GatherIndex(kLanes, from + 1, at);
            return hn::MulAdd(fv, hn::Sub(next, here), here);
        };
        const Vec left = blend(pixels), right = blend(pixels + view.stride);
        const Vec value = hn::MulAdd(fu, hn::Sub(right, left), left);
        hn::StoreU(hn::MulAdd(hn::Mul(inverse, inverse), value, hn::LoadU(kLanes, sums + k)), kLanes, sums + k);
    }
}

/// The same for an upright column whose voxels and rows ascend together: all are at one place between two detector
/// columns, and a vector of voxels finds its rows in two vectors of those.
void addUpright(const FilteredView& view, const float* pixels, const VoxelColumn& voxels, float* sums) {
    const float inverse = 1 / voxels.depth.first;
    const float u = std::min(std::max(voxels.x.first * inverse + 1, 0.0f), float(view.width + 1));
    if (u <= 0 || u >= float(view.width + 1)) return;  // beside the detector
    const Progression y{voxels.y.first * inverse, voxels.y.step * inverse};
    const int column = int(u);
    const Vec fu = hn::Set(kLanes, u - float(column)), weight = hn::Set(kLanes, inverse * inverse);
    const float* left = pixels + std::size_t(column) * view.stride;
    const float* right = left + view.stride;
    const auto blend = [&](int row) {
        const Vec l = hn::LoadU(kLanes, left + row), r = hn::LoadU(kLanes, right + row);
        return hn::Mul(weight, hn::MulAdd(fu, hn::Sub(r, l), l));
    };
    for (int k = 0; k < voxels.count; k += kLaneCount) {
        const Vec v = inRim(y.from(k), view.height);
        const Vec row = hn::Floor(v);
        const IntVec index = hn::ConvertTo(kIntLanes, row);
        const int base = hn::GetLane(index);
        const IntVec behind = hn::Sub(index, hn::Set(kIntLanes, base));
        const Vec low = blend(base), high = blend(base + kLaneCount);
        const Vec here = lookup(low, high, behind);
        const Vec next = lookup(low, high, hn::Add(behind, hn::Set(kIntLanes, 1)));
        const Vec value = hn::MulAdd(hn::Sub(v, row), hn::Sub(next, here), here);
        hn::StoreU(hn::Add(hn::LoadU(kLanes, sums + k), value), kLanes, sums + k);
    }
}

}  // namespace

void addFilteredViewsDispatched(const FilteredViews& views, const VoxelColumns& columns, int firstA, int firstB,
                                float* sums) {
    const int count = columns.dim(2), padded = paddedColumn(count), axis = columns.axes[2];
    const int endA = std::min(kFbpBlock, columns.dim(0) - firstA), endB = std::min(kFbpBlock, columns.dim(1) - firstB);
    for (const FilteredView& view : views.views()) {
        const float* pixels = views.pixels(view);
        for (int a = 0; a < endA; ++a)
            for (int b = 0; b < endB; ++b) {
                const VoxelColumn voxels(view.matrix, columns.lowest(firstA + a, firstB + b),
                                         columns.where.spacing[axis], axis, count);
                float* to = sums + std::size_t(a * kFbpBlock + b) * std::size_t(padded);
                if (voxels.isUpright() && fitsTables(voxels.y.step / voxels.depth.first))
                    addUpright(view, pixels, voxels, to);
                else
                    addTilted(view, pixels, voxels, to);
            }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace raysweep
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace raysweep {

HWY_EXPORT(addFilteredViewsDispatched);

void addFilteredViews(const FilteredViews& views, const VoxelColumns& columns, int a, int b, float* sums) {
    HWY_DYNAMIC_DISPATCH(addFilteredViewsDispatched)(views, columns, a, b, sums);
}

void FilteredViews::add(const ViewMatrix& matrix, int width, int height, int columnAxis) {
    FilteredView view;
    view.width = width;
    view.height = height;
    view.offset = size_;
    view.stride = std::size_t(height) + 3;
    view.matrix = matrix;
    view.reversed = matrix.y.a[columnAxis] < 0;
    if (view.reversed) {
        view.matrix.y.a = matrix.depth.a * double(height - 1) - matrix.y.a;
        view.matrix.y.b = matrix.depth.b * double(height - 1) - matrix.y.b;
    }
    size_ += view.stride * (std::size_t(width) + 3);
    views_.push_back(view);
}

void FilteredViews::allocate() {
    values_.assign(size_ + 2 * kFbpChunk, 0.0f);  // vectors of rows are read beyond the last one
}

void FilteredViews::setRows(std::size_t n, const float* rows) {
    const FilteredView& view = views_[n];
    const std::size_t width = std::size_t(view.width), height = std::size_t(view.height);
    constexpr std::size_t kTogether = 16;  // columns: what lies beside each other is read together
    parallelFor((width + kTogether - 1) / kTogether, [&](std::size_t task) {
        const std::size_t first = task * kTogether, last = std::min(width, first + kTogether);
        for (std::size_t y = 0; y < height; ++y) {
            float* to = values_.data() + view.offset + 1 + (view.reversed ? height - 1 - y : y);
            for (std::size_t x = first; x < last; ++x) to[(x + 1) * view.stride] = rows[y * width + x];
        }
    });
}

}  // namespace raysweep
#endif  // HWY_ONCE
