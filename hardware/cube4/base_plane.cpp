#include "cube4/base_plane.h"

#include "raysweep/core/error.h"

#include <cmath>

namespace raysweep::cube4 {
namespace {

constexpr double kWhole = 1e-6;  ///< pixels, voxels: what is this close to a whole number is one

Matrix3 rows(const Vec3& a, const Vec3& b, const Vec3& c) {
    return Matrix3(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z);
}

}  // namespace

double snapped(double value) {
    const double whole = std::round(value);
    return std::abs(value - whole) < kWhole ? whole : value;
}

BasePlane::BasePlane(const PixelRays& view, const DenseBox& box, const Vec3& origin, int pad, const ContentBox& content,
                     double depth) {
    const Matrix3 memoryFromWorld = box.worldFromIndex.inverse();
    memoryFromPixel_ =
        rows(view.column * memoryFromWorld, view.row * memoryFromWorld, view.direction.normalized() * memoryFromWorld);
    if (!(std::abs(memoryFromPixel_.determinant()) > 0))
        throw InvalidArgument("a view's rays run along its detector, or its pixels have no area");
    pixelFromMemory_ = memoryFromPixel_.inverse();
    originInMemory_ = (view.origin - origin) * memoryFromWorld + Vec3(double(pad));

    direction_.alongIndex = view.direction.normalized() * memoryFromWorld;
    // Where the first pixel's ray meets the first slice: the lattice is to have a ray there.
    const Traversal traversal = traverse(box.size() + Index3(2 * pad), content, direction_, Resampling::linear);
    const double sense = traversal.descending ? -1 : 1;
    const double slice = traversal.origin[traversal.major] + sense * depth;
    const double along = (slice - originInMemory_[traversal.major]) / direction_.alongIndex[traversal.major];
    const auto offset = [&](int axis) {
        const double at = snapped(originInMemory_[axis] + along * direction_.alongIndex[axis]);
        return at - std::floor(at);
    };
    direction_.offsetU = offset(traversal.axisU);
    direction_.offsetV = offset(traversal.axisV);
}

Imath::V2d BasePlane::pixelOf(const Traversal& traversal, double u, double v, double k) const {
    Vec3 memory;
    const double sense = traversal.descending ? -1 : 1;
    memory[traversal.axisU] = traversal.origin[traversal.axisU] + sense * u;
    memory[traversal.axisV] = traversal.origin[traversal.axisV] + sense * v;
    memory[traversal.major] = traversal.origin[traversal.major] + sense * k;
    const Vec3 pixel = (memory - originInMemory_) * pixelFromMemory_;
    return {snapped(pixel.x), snapped(pixel.y)};
}

Imath::V2d BasePlane::positionOf(const Traversal& traversal, double column, double row, double k) const {
    Vec3 memory = originInMemory_ + Vec3(column, row, 0) * memoryFromPixel_;
    const double sense = traversal.descending ? -1 : 1;
    const double slice = traversal.origin[traversal.major] + sense * k;
    memory += direction_.alongIndex * ((slice - memory[traversal.major]) / direction_.alongIndex[traversal.major]);
    return {snapped(sense * (memory[traversal.axisU] - traversal.origin[traversal.axisU])),
            snapped(sense * (memory[traversal.axisV] - traversal.origin[traversal.axisV]))};
}

float sampleOf(const std::vector<float>& values, int width, int height, const Imath::V2d& at) {
    const double left = std::floor(at.x), below = std::floor(at.y);
    const double x = at.x - left, y = at.y - below;
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        const double weight = (i & 1 ? x : 1 - x) * (i & 2 ? y : 1 - y);
        if (!(weight > 0)) continue;
        const double column = left + (i & 1), row = below + (i >> 1);
        if (!(column >= 0 && column < width && row >= 0 && row < height)) return std::nanf("");
        sum += weight * double(values[std::size_t(row) * std::size_t(width) + std::size_t(column)]);
    }
    return float(sum);
}

}  // namespace raysweep::cube4
