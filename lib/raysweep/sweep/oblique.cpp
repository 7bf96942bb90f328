#include "raysweep/sweep/oblique.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// Voxels [low, high).
struct VoxelBox {
    Index3 low, high;
};

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

/// Detector pixels [low, high).
struct PixelBox {
    int lowColumn, highColumn, lowRow, highRow;
};

/// The pixels whose rays may meet `box` or the voxels one beside it.
PixelBox pixelsMeeting(const ViewFootprint& f, const VoxelBox& box) {
    const PixelBox all{0, f.width, 0, f.height};
    const Vec3 normal = f.view.column.cross(f.view.row);
    double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
    for (int corner = 0; corner < 8; ++corner) {
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis) point[axis] = (corner >> axis) & 1 ? box.high[axis] : box.low[axis] - 1;
        const bool cone = f.beam == BeamShape::cone;
        const Vec3 from = cone ? f.view.source : point, along = cone ? point - f.view.source : f.view.direction;
        const double t = normal.dot(f.view.origin - from) / normal.dot(along);
        if (cone && !(t > 0 && t < 1e9)) return all;  // beside or behind the source
        // Where the ray through the corner meets the detector, in its columns and rows (Cramer's rule).
        const Vec3 place = from + along * t - f.view.origin;
        const double area = normal.dot(normal);
        const double at[2] = {place.cross(f.view.row).dot(normal) / area,
                              f.view.column.cross(place).dot(normal) / area};
        for (int i = 0; i < 2; ++i) {
            low[i] = std::min(low[i], at[i]);
            high[i] = std::max(high[i], at[i]);
        }
    }
    const auto limited = [](double value, int count) { return int(std::clamp(value, 0.0, double(count))); };
    return {limited(std::floor(low[0]), f.width), limited(std::ceil(high[0]) + 1, f.width),
            limited(std::floor(low[1]), f.height), limited(std::ceil(high[1]) + 1, f.height)};
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
    const PixelBox pixels = pixelsMeeting(rays.footprint, box);
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
