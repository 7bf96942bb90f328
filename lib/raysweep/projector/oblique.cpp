#include "raysweep/projector/oblique.h"

#include "raysweep/projector/footprint.h"

#include <algorithm>

namespace raysweep {
namespace {

/// Calls `use(voxel, weight)` for the voxels of `box` around each point where `line` meets a slice of it.
template <class Use>
void forEachVoxelBeside(const RayLine& line, const VoxelBox& box, const Use& use) {
    const int others[2] = {line.axis == 0 ? 1 : 0, line.axis == 2 ? 1 : 2};
    const int first = std::max(line.slices.first, box.low[line.axis]);
    const int last = std::min(line.slices.last, box.high[line.axis]);
    for (int slice = first; slice < last; ++slice) {
        const LateralWeights w[2] = {line.beside(0, slice), line.beside(1, slice)};
        Index3 voxel;
        voxel[line.axis] = slice;
        for (int p = 0; p < 2; ++p) {
            voxel[others[0]] = w[0].below + p;
            if (voxel[others[0]] < box.low[others[0]] || voxel[others[0]] >= box.high[others[0]]) continue;
            const float weight = p ? w[0].upper : w[0].lower;
            for (int q = 0; q < 2; ++q) {
                voxel[others[1]] = w[1].below + q;
                if (voxel[others[1]] < box.low[others[1]] || voxel[others[1]] >= box.high[others[1]]) continue;
                use(voxel, weight * (q ? w[1].upper : w[1].lower));
            }
        }
    }
}

}  // namespace

void projectOblique(const ColumnVolume& volume, IndexRange columns, ViewRays& rays) {
    const JosephView& view = rays.view;
    const Index3 dims = volume.lattice().dims;
    const VoxelBox whole{Index3(0), dims};
    for (int column = columns.first; column < columns.last; ++column)
        for (int row = 0; row < view.height; ++row) {
            const RayLine line = rayLine(view, dims, column, row);
            double value = 0, weight = 0;
            forEachVoxelBeside(line, whole, [&](const Index3& voxel, float part) {
                const std::size_t block = volume.blockOf(voxel.x, voxel.y);
                const ColumnRange range = volume.ranges()[block];
                if (voxel.z < range.low || voxel.z >= range.high) return;
                value += double(part) * volume.column(block, voxel.x, voxel.y)[voxel.z - range.low];
                weight += part;
            });
            rays.values.column(column)[row] = float(value * line.length);
            rays.weights.column(column)[row] = float(weight * line.length);
        }
}

void backprojectOblique(const ColumnVolume& layout, std::size_t block, const ViewRays& rays, float* values,
                        float* weights) {
    const Index3 dims = layout.lattice().dims;
    const ColumnRange range = layout.ranges()[block];
    VoxelBox box;
    box.low = Index3(layout.firstX(block), layout.firstY(block), range.low);
    box.high = Index3(std::min(box.low.x + kBlockEdge, dims.x), std::min(box.low.y + kBlockEdge, dims.y),
                      std::min(range.high, dims.z));
    const PixelBox pixels = footprintOf(box, rays.view);
    for (int column = pixels.lowColumn; column < pixels.highColumn; ++column)
        for (int row = pixels.lowRow; row < pixels.highRow; ++row) {
            const RayLine line = rayLine(rays.view, dims, column, row);
            const float value = rays.values.column(column)[row] * line.length;
            const float weight = rays.weights.column(column)[row] * line.length;
            forEachVoxelBeside(line, box, [&](const Index3& voxel, float part) {
                const std::size_t offset =
                    std::size_t((voxel.x - box.low.x) * kBlockEdge + voxel.y - box.low.y) * range.length() +
                    std::size_t(voxel.z - range.low);
                values[offset] += part * value;
                weights[offset] += part * weight;
            });
        }
}

}  // namespace raysweep
