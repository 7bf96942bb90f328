#include "raysweep/projector/oblique.h"

#include "raysweep/projector/shadow.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// Calls `use(voxel, weight)` for the voxels of `box` around each point where `line` meets a slice of it.
template <class Use>
void forEachVoxelBeside(const RayLine& line, const VoxelBox& box, const Use& use) {
    const int others[2] = {line.axis == 0 ? 1 : 0, line.axis == 2 ? 1 : 2};
    const int first = std::max(line.slices.first, box.low[line.axis]);
    const int last = std::min(line.slices.last, box.high[line.axis]);
    for (int slice = first; slice < last; ++slice) {
        int below[2];
        float upper[2];
        for (int i = 0; i < 2; ++i) {
            const double lateral = line.lateral0[i] + line.lateral1[i] * slice;
            below[i] = int(std::floor(lateral));
            upper[i] = float(lateral - below[i]);
        }
        Index3 voxel;
        voxel[line.axis] = slice;
        for (int p = 0; p < 2; ++p) {
            voxel[others[0]] = below[0] + p;
            if (voxel[others[0]] < box.low[others[0]] || voxel[others[0]] >= box.high[others[0]]) continue;
            const float weight = p ? upper[0] : 1 - upper[0];
            for (int q = 0; q < 2; ++q) {
                voxel[others[1]] = below[1] + q;
                if (voxel[others[1]] < box.low[others[1]] || voxel[others[1]] >= box.high[others[1]]) continue;
                use(voxel, weight * (q ? upper[1] : 1 - upper[1]));
            }
        }
    }
}

}  // namespace

void projectOblique(const ColumnVolume& volume, int first, int last, ViewRays& rays) {
    const ViewFootprint& footprint = rays.footprint;
    const Index3 dims = volume.lattice().dims;
    const VoxelBox whole{Index3(0), dims};
    for (int column = first; column < last; ++column)
        for (int row = 0; row < footprint.height; ++row) {
            const RayLine line = rayLine(footprint, dims, column, row);
            double value = 0, weight = 0;
            forEachVoxelBeside(line, whole, [&](const Index3& voxel, float part) {
                const std::size_t tile = volume.tileOf(voxel.x, voxel.y);
                const ColumnRange range = volume.ranges()[tile];
                if (voxel.z < range.low || voxel.z >= range.high) return;
                value += double(part) * volume.column(tile, voxel.x, voxel.y)[voxel.z - range.low];
                weight += part;
            });
            rays.values.column(column)[row] = float(value * line.length);
            rays.weights.column(column)[row] = float(weight * line.length);
        }
}

void backprojectOblique(const ColumnVolume& layout, std::size_t tile, const ViewRays& rays, float* values,
                        float* weights) {
    const Index3 dims = layout.lattice().dims;
    const ColumnRange range = layout.ranges()[tile];
    VoxelBox box;
    box.low = Index3(int(tile) / layout.tilesY() * kTileEdge, int(tile) % layout.tilesY() * kTileEdge, range.low);
    box.high = Index3(std::min(box.low.x + kTileEdge, dims.x), std::min(box.low.y + kTileEdge, dims.y),
                      std::min(range.high, dims.z));
    const PixelBox pixels = shadowOf(box, rays.footprint);
    for (int column = pixels.lowColumn; column < pixels.highColumn; ++column)
        for (int row = pixels.lowRow; row < pixels.highRow; ++row) {
            const RayLine line = rayLine(rays.footprint, dims, column, row);
            const float value = rays.values.column(column)[row] * line.length;
            const float weight = rays.weights.column(column)[row] * line.length;
            forEachVoxelBeside(line, box, [&](const Index3& voxel, float part) {
                const std::size_t offset =
                    std::size_t((voxel.x - box.low.x) * kTileEdge + voxel.y - box.low.y) * range.length() +
                    std::size_t(voxel.z - range.low);
                values[offset] += part * value;
                weights[offset] += part * weight;
            });
        }
}

}  // namespace raysweep
