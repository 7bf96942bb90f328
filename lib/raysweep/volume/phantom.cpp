#include "raysweep/volume/phantom.h"

#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/core/types.h"
#include "raysweep/volume/cloud_shape.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Leaf = openvdb::FloatTree::LeafNodeType;

/// Half the diagonal of a leaf, voxels: nothing in it is further from its centre.
const double kLeafRadius = 3.5 * std::sqrt(3.0);

void require(bool holds, const std::string& field, double value, const std::string& bound) {
    if (!holds) throw InvalidArgument(field + " is " + std::to_string(value) + ", but must be " + bound);
}

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

/// Activates the voxels of [0,box) for which `density(position, leafData)` is above 0; `position` is the voxel's index
/// relative to the centre of the box. `prepare(centre, leafData)` is called before, once per leaf; where it returns
/// false the leaf is empty.
template <class LeafData, class Prepare, class Density>
void fill(FloatGrid& grid, const Coord& box, const Prepare& prepare, const Density& density) {
    const Coord leaves((box.x() + 7) / 8, (box.y() + 7) / 8, (box.z() + 7) / 8);
    const Vec3 middle(0.5 * (box.x() - 1), 0.5 * (box.y() - 1), 0.5 * (box.z() - 1));
    const auto fromMiddle = [&](const Coord& ijk) { return Vec3(ijk.x(), ijk.y(), ijk.z()) - middle; };
    std::vector<std::unique_ptr<Leaf>> made(std::size_t(leaves.x()) * leaves.y() * leaves.z());
    parallelFor(made.size(), [&](std::size_t n) {
        const Coord origin(8 * int(n / (std::size_t(leaves.y()) * leaves.z())), 8 * int(n / leaves.z() % leaves.y()),
                           8 * int(n % leaves.z()));
        LeafData data;
        if (!prepare(fromMiddle(origin) + Vec3(3.5), data)) return;
        auto leaf = std::make_unique<Leaf>(origin, 0.0f);
        for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const Coord ijk = leaf->offsetToGlobalCoord(offset);
            if (ijk.x() >= box.x() || ijk.y() >= box.y() || ijk.z() >= box.z()) continue;
            const double value = density(fromMiddle(ijk), data);
            if (value > 0) leaf->setValueOn(offset, float(value));
        }
        if (!leaf->isEmpty()) made[n] = std::move(leaf);
    });
    for (auto& leaf : made)
        if (leaf) grid.tree().addLeaf(leaf.release());
}

}  // namespace

void PhantomOptions::validate() const {
    require(size >= 2 && size <= 4096, "size", size, "in [2,4096]");
    require(voxelSize >= 0 && std::isfinite(voxelSize), "voxelSize", voxelSize, "0 (automatic) or larger");
    require(density > 0 && std::isfinite(density), "density", density, "larger than 0");
    require(soft >= 0 && soft <= 0.5 * size, "soft", soft, "in [0,size/2]");
    const bool automatic = dims == Coord(0, 0, 0);
    for (int axis = 0; axis < 3 && !automatic; ++axis)
        require(dims[axis] >= 1 && dims[axis] <= 4096, "dims", dims[axis], "in [1,4096] on each axis");
}

FloatGrid::Ptr makeSphere(const PhantomOptions& options) {
    options.validate();
    const Coord box(options.size);
    const FloatGrid::Ptr grid = makeGrid(options, box);
    const double radius = 0.5 * (options.size - options.soft);
    const double reach = radius + 0.5 * options.soft + kLeafRadius;
    const auto near = [&](const Vec3& centre, int&) { return centre.length() <= reach; };
    fill<int>(*grid, box, near, [&](const Vec3& p, int) {
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
    fill<int>(*grid, box, always, [&](const Vec3&, int) { return double(options.density); });
    return grid;
}

FloatGrid::Ptr makeCloud(const PhantomOptions& options) {
    options.validate();
    const CloudShape shape = makeCloudShape(options.seed);
    const Vec3 extent = shape.high - shape.low, centre = (shape.high + shape.low) * 0.5;
    const double h = std::max({extent.x, extent.y, extent.z}) / options.size;  // shape units per voxel
    const Coord box(int(std::ceil(extent.x / h - 1e-6)), int(std::ceil(extent.y / h - 1e-6)),
                    int(std::ceil(extent.z / h - 1e-6)));
    const FloatGrid::Ptr grid = makeGrid(options, box);
    const auto near = [&](const Vec3& leafCentre, std::vector<CloudPuff>& puffs) {
        puffs = puffsNear(shape, centre + leafCentre * h, kLeafRadius * h);
        return !puffs.empty();
    };
    fill<std::vector<CloudPuff>>(*grid, box, near, [&](const Vec3& p, const std::vector<CloudPuff>& puffs) {
        return options.density * cloudDensity(shape, puffs, centre + p * h);
    });
    return grid;
}

}  // namespace raysweep
