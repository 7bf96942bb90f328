#include "raysweep/phantoms/phantom.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"
#include "raysweep/core/types.h"
#include "raysweep/phantoms/cloud_shape.h"
#include "raysweep/phantoms/leaf_fill.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;

FloatGrid::Ptr makeGrid(const PhantomOptions& options, const Coord& box) {
    const int longest = std::max({box.x(), box.y(), box.z()});
    const double h = options.voxelSize > 0 ? options.voxelSize : 2.0 / longest;
    const auto transform = openvdb::math::Transform::createLinearTransform(h);
    transform->postTranslate(openvdb::Vec3d(box.x() - 1, box.y() - 1, box.z() - 1) * (-0.5 * h));
    FloatGrid::Ptr grid = FloatGrid::create(0.0f);
    grid->setTransform(transform);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

FillRegion regionOf(const Coord& box) {
    return {openvdb::CoordBBox(Coord(0), box.offsetBy(-1)), Vec3(box.x() - 1, box.y() - 1, box.z() - 1) * 0.5};
}

}  // namespace

void PhantomOptions::validate() const {
    requireField(size >= 2 && size <= 4096, "size", size, "in [2,4096]");
    requireField(voxelSize >= 0 && std::isfinite(voxelSize), "voxelSize", voxelSize, "0 (automatic) or larger");
    requireField(density > 0 && std::isfinite(density), "density", density, "larger than 0");
    requireField(soft >= 0 && soft <= 0.5 * size, "soft", soft, "in [0,size/2]");
    const bool automatic = dims == Coord(0, 0, 0);
    for (int axis = 0; axis < 3 && !automatic; ++axis)
        requireField(dims[axis] >= 1 && dims[axis] <= 4096, "dims", dims[axis], "in [1,4096] on each axis");
}

FloatGrid::Ptr makeSphere(const PhantomOptions& options) {
    options.validate();
    const Coord box(options.size);
    const FloatGrid::Ptr grid = makeGrid(options, box);
    const double radius = 0.5 * (options.size - options.soft);
    const double reach = radius + 0.5 * options.soft + kLeafRadius;
    const auto near = [&](const Vec3& centre, int&) { return centre.length() <= reach; };
    fillLeaves<int>(*grid, regionOf(box), near, [&](const Vec3& p, int) {
        const double outside = p.length() - radius;
        if (options.soft == 0) return outside <= 0 ? double(options.density) : 0.0;
        return options.density * std::clamp(0.5 - outside / options.soft, 0.0, 1.0);
    });
    return grid;
}

FloatGrid::Ptr makeBox(const PhantomOptions& options) {
    options.validate();
    const Coord box = options.dims == Coord(0, 0, 0) ? Coord(options.size) : options.dims;
    const FloatGrid::Ptr grid = makeGrid(options, box);
    const auto always = [](const Vec3&, int&) { return true; };
    fillLeaves<int>(*grid, regionOf(box), always, [&](const Vec3&, int) { return double(options.density); });
    return grid;
}

FloatGrid::Ptr makeCloud(const PhantomOptions& options) {
    options.validate();
    const CloudShape shape = makeCloudShape(options.seed);
    const Vec3 extent = shape.high - shape.low, centre = (shape.high + shape.low) * 0.5;  // of what is seen
    const double h = std::max({extent.x, extent.y, extent.z}) / options.size;             // shape units per voxel
    const Coord box(int(std::ceil(extent.x / h - 1e-6)), int(std::ceil(extent.y / h - 1e-6)),
                    int(std::ceil(extent.z / h - 1e-6)));
    const FloatGrid::Ptr grid = makeGrid(options, box);
    // The shape's box was found by samples, so a wisp may reach out of it; it is not cut off.
    FillRegion region = regionOf(box);
    for (int axis = 0; axis < 3; ++axis) {
        region.box.min()[axis] += int(std::floor((shape.outerLow[axis] - shape.low[axis]) / h));
        region.box.max()[axis] += int(std::ceil((shape.outerHigh[axis] - shape.high[axis]) / h));
    }
    const auto near = [&](const Vec3& leafCentre, std::vector<CloudPuff>& puffs) {
        puffs = puffsNear(shape, centre + leafCentre * h, kLeafRadius * h);
        return !puffs.empty();
    };
    fillLeaves<std::vector<CloudPuff>>(*grid, region, near, [&](const Vec3& p, const std::vector<CloudPuff>& puffs) {
        return options.density * cloudDensity(shape, puffs, centre + p * h);
    });
    return grid;
}

}  // namespace raysweep
