#include "raysweep/volume/middle_slices.h"

#include "raysweep/core/require.h"
#include "raysweep/image/image_io.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace raysweep {
namespace {

constexpr int kGap = 4;       ///< pixels between slices
constexpr int kThinnest = 8;  ///< voxels; what is thinner is not shown from the side

/// A slice across axis `normal`: axis `right` to the right, `up` upwards.
struct Slice {
    int normal, right, up;
};
constexpr Slice kSlices[] = {{2, 0, 1}, {1, 0, 2}, {0, 1, 2}};

/// Pixels for each axis of the volume, as long as its voxels are, relative to their shortest edge.
Index3 pixelsFor(const openvdb::FloatGrid& grid, const Index3& dims) {
    constexpr double kLongest = 16;
    const openvdb::Vec3d edges = grid.voxelSize();
    const double shortest = std::min({edges[0], edges[1], edges[2]});
    Index3 pixels;
    for (int axis = 0; axis < 3; ++axis)
        pixels[axis] = int(std::lround(dims[axis] * std::min(kLongest, edges[axis] / shortest)));
    return pixels;
}

}  // namespace

Image middleSlices(const openvdb::FloatGrid& grid, const Index3& dims) {
    for (int axis = 0; axis < 3; ++axis)
        requireField(dims[axis] >= 1, "dims[" + std::to_string(axis) + "]", dims[axis], "at least 1");
    const Index3 pixels = pixelsFor(grid, dims);
    const auto voxelAt = [&](int axis, int pixel) { return int((pixel + 0.5) * dims[axis] / pixels[axis]); };
    std::vector<Slice> shown;
    int width = -kGap, height = 0;
    for (const Slice& slice : kSlices) {
        if (!shown.empty() && dims[slice.up] < kThinnest) continue;
        shown.push_back(slice);
        width += pixels[slice.right] + kGap;
        height = std::max(height, pixels[slice.up]);
    }
    Image image(width, height, 3);
    std::fill(image.pixels.begin(), image.pixels.end(), -std::numeric_limits<float>::infinity());
    float least = 0, most = 0;
    auto values = grid.getConstAccessor();
    int left = 0;
    for (const Slice& slice : shown) {
        openvdb::Coord voxel;
        voxel[slice.normal] = dims[slice.normal] / 2;
        for (int y = 0; y < pixels[slice.up]; ++y)
            for (int x = 0; x < pixels[slice.right]; ++x) {
                voxel[slice.right] = voxelAt(slice.right, x);
                voxel[slice.up] = dims[slice.up] - 1 - voxelAt(slice.up, y);
                const float value = values.getValue(voxel);
                least = std::min(least, value);
                most = std::max(most, value);
                std::fill_n(image.at(left + x, y), 3, value);
            }
        left += pixels[slice.right] + kGap;
    }
    const float range = most > least ? most - least : 1;
    for (float& value : image.pixels) value = linearFromSrgb(std::clamp((value - least) / range, 0.0f, 1.0f));
    return image;
}

}  // namespace raysweep
