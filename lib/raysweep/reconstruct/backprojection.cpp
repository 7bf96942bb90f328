// Eq. 3 and 4 of fbp.h: each view is weighted and filtered, then each voxel sums what the views show where it falls.
#include "raysweep/reconstruct/backprojection.h"

#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/core/parallel.h"
#include "raysweep/reconstruct/filtered_views.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

namespace raysweep {
namespace {

void requireFinite(const Projections& projections) {
    const ValuesFound bad = findValues(projections, [](float value) { return !std::isfinite(value); });
    if (bad.count > 0)
        throw InvalidArgument(placeOf(projections, bad.first) + ": the value is " +
                              std::to_string(projections.values[bad.first]) +
                              "; filtered backprojection needs all pixels, so fill in what was not measured");
}

using Leaf = openvdb::FloatTree::LeafNodeType;

/// Weights, and filters: what eq. 3 and 4 have before the sum over views.
void filterView(FilteredViews& filtered, std::size_t n, const float* pixels, const DirectScan& scan,
                const RampFilter& ramp) {
    const AlignedView& view = scan.views[n];
    const std::size_t width = std::size_t(view.width), height = std::size_t(view.height);
    std::vector<float> rows(width * height);
    alignedRows(view, scan.geometry, pixels, rows.data());
    const std::vector<double> columns = scan.columnWeights(n);
    parallelFor(
        height,
        [&](std::size_t y) {
            for (std::size_t x = 0; x < width; ++x)
                rows[y * width + x] = float(rows[y * width + x] * columns[x] * scan.cosine(n, double(x), double(y)));
        },
        4);
    ramp.apply(rows.data(), height, width);
    filtered.setRows(n, rows.data());
}

/// The voxels of the leaves above each other at column (a,b), a and b multiples of 8: 64 columns.
std::vector<float> backprojectColumns(const FilteredViews& views, const VoxelColumns& columns, int a, int b) {
    std::vector<float> sums(std::size_t(kFbpBlock) * kFbpBlock * std::size_t(paddedColumn(columns.dim(2))));
    addFilteredViews(views, columns, a, b, sums.data());
    return sums;
}

using Leaves = std::vector<std::unique_ptr<Leaf>>;

Leaves leavesOf(const std::vector<float>& sums, const VoxelColumns& columns, int a, int b, const FbpOptions& options) {
    const int count = columns.dim(2), padded = paddedColumn(count);
    Leaves leaves;
    for (int k = 0; k < count; k += kFbpBlock) {
        openvdb::Coord corner;
        corner[columns.axes[0]] = a;
        corner[columns.axes[1]] = b;
        corner[columns.axes[2]] = k;
        auto leaf = std::make_unique<Leaf>(corner, 0.0f);
        for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const openvdb::Coord voxel = Leaf::offsetToLocalCoord(offset);
            const int inA = voxel[columns.axes[0]], inB = voxel[columns.axes[1]], above = k + voxel[columns.axes[2]];
            if (above >= count || a + inA >= columns.dim(0) || b + inB >= columns.dim(1)) continue;
            const float value = sums[std::size_t(inA * kFbpBlock + inB) * std::size_t(padded) + std::size_t(above)];
            if (options.nonNegative ? value > options.tolerance : std::abs(value) > options.tolerance)
                leaf->setValueOn(offset, value);
        }
        if (!leaf->isEmpty()) leaves.push_back(std::move(leaf));
    }
    return leaves;
}

/// The depths of the grid's corners bound those of all its voxels.
void requireInFront(const FilteredViews& filtered, const ReconstructionGrid& where) {
    const std::vector<FilteredView>& views = filtered.views();
    for (std::size_t n = 0; n < views.size(); ++n)
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 p = where.voxel(corner & 1 ? where.dims.x - 1 : 0, corner & 2 ? where.dims.y - 1 : 0,
                                       corner & 4 ? where.dims.z - 1 : 0);
            if (!(views[n].matrix.depth(p) > 1e-6))
                throw InvalidArgument("view " + std::to_string(n) +
                                      ": the reconstruction grid reaches behind the source; take a smaller one");
        }
}

/// Room for all views, and where they fall. The columns of voxels run along the axis of the turn, as near as they can.
FilteredViews filteredViews(const DirectScan& scan, int columnAxis) {
    FilteredViews filtered;
    for (const AlignedView& view : scan.views)
        filtered.add(viewMatrix(view.xray, scan.geometry.beam), view.width, view.height, columnAxis);
    requireBytes(filtered.bytes(), "the filtered projections need",
                 "take less views, or less of the detector's rows, or an iterative method");
    return filtered;
}

/// @return false if `progress` asked to stop.
bool filterViews(FilteredViews& filtered, const ViewPixels& pixels, const DirectScan& scan, const FbpOptions& options,
                 const ProgressCallback& progress) {
    std::map<int, RampFilter> ramps;  // by the width of aligned detectors
    std::vector<float> room;
    filtered.allocate();
    for (std::size_t n = 0; n < scan.views.size(); ++n) {
        if (!report(progress, "filtering", double(n) / double(scan.views.size()))) return false;
        const int width = scan.views[n].width;
        const auto ramp = ramps.try_emplace(width, width, options.window, options.cutoff).first;
        filterView(filtered, n, pixels(n, room), scan, ramp->second);
    }
    return true;
}

void backproject(const FilteredViews& filtered, const VoxelColumns& columns, const FbpOptions& options,
                 const ProgressCallback& progress, openvdb::FloatGrid& grid) {
    for (int a = 0; a < columns.dim(0); a += kFbpBlock) {
        if (!report(progress, "backprojecting", double(a) / columns.dim(0))) return;
        std::vector<Leaves> made(std::size_t((columns.dim(1) + kFbpBlock - 1) / kFbpBlock));
        parallelFor(made.size(), [&](std::size_t block) {
            const int b = int(block) * kFbpBlock;
            made[block] = leavesOf(backprojectColumns(filtered, columns, a, b), columns, a, b, options);
        });
        for (Leaves& leaves : made)
            for (auto& leaf : leaves) grid.tree().addLeaf(leaf.release());
    }
}

}  // namespace

void requireUsable(const DirectScan& scan, const Projections& projections) {
    requireFinite(projections);
    scan.requireAxisSeen();
    scan.requireLines(projections);
}

openvdb::FloatGrid::Ptr backprojection(const DirectScan& scan, const ViewPixels& pixels,
                                       const ReconstructionGrid& where, const FbpOptions& options,
                                       const ProgressCallback& progress) {
    const VoxelColumns columns(where, majorAxis(scan.orbit.axis));
    FilteredViews filtered = filteredViews(scan, columns.axes[2]);
    requireInFront(filtered, where);

    const auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(where.transform());
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    if (filterViews(filtered, pixels, scan, options, progress))
        backproject(filtered, columns, options, progress, *grid);
    return grid;
}

}  // namespace raysweep
