#include "raysweep/volume/middle_slices.h"

#include "raysweep/core/require.h"
#include "raysweep/image/image_io.h"

#include <algorithm>
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

}  // namespace

Image middleSlices(const openvdb::FloatGrid& grid, const Index3& dims) {
    for (int axis = 0; axis < 3; ++axis)
        requireField(dims[axis] >= 1, "dims[" + std::to_string(axis) + "]", dims[axis], "at least 1");
    std::vector<Slice> shown;
    int width = -kGap, height = 0;
    for (const Slice& slice : kSlices) {
        if (!shown.empty() && dims[slice.up] < kThinnest) continue;
        shown.push_back(slice);
        width += dims[slice.right] + kGap;
        height = std::max(height, dims[slice.up]);
    }
    Image image(width, height, 3);
    std::fill(image.pixels.begin(), image.pixels.end(), -std::numeric_limits<float>::infinity());
    float least = 0, most = 0;
    auto values = grid.getConstAccessor();
    int left = 0;
    for (const Slice& slice : shown) {
        openvdb::Coord voxel;
        voxel[slice.normal] = dims[slice.normal] / 2;
        for (int y = 0; y < dims[slice.up]; ++y)
            for (int x = 0; x < dims[slice.right]; ++x) {
                voxel[slice.right] = x;
                voxel[slice.up] = dims[slice.up] - 1 - y;
                const float value = values.getValue(voxel);
                least = std::min(least, value);
                most = std::max(most, value);
                std::fill_n(image.at(left + x, y), 3, value);
            }
        left += dims[slice.right] + kGap;
    }
    const float range = most > least ? most - least : 1;
    for (float& value : image.pixels) value = linearFromSrgb(std::clamp((value - least) / range, 0.0f, 1.0f));
    return image;
}

}  // namespace raysweep
