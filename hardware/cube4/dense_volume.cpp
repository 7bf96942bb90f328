#include "cube4/dense_volume.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/grid_transform.h"

#include <string>

namespace raysweep::cube4 {
namespace {

constexpr int kBlock = 8;

Index3 toIndex(const openvdb::Coord& at) {
    return Index3(at.x(), at.y(), at.z());
}

Matrix3 linearPart(const openvdb::GridBase& grid) {
    requireLinear(grid);
    const openvdb::Mat4d all = grid.transform().baseMap()->getAffineMap()->getMat4();
    Matrix3 linear;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) linear[i][j] = all(i, j);
    return linear;
}

int blockBelow(int at) {
    return (at >= 0 ? at / kBlock : -((-at + kBlock - 1) / kBlock)) * kBlock;
}

/// Calls `visit(voxel, value)` for active voxels within the box.
template <class Grid, class Visit>
void forEachInside(const Grid& grid, const DenseBox& box, const Visit& visit) {
    const openvdb::CoordBBox inside(openvdb::Coord(box.low.x, box.low.y, box.low.z),
                                    openvdb::Coord(box.high.x - 1, box.high.y - 1, box.high.z - 1));
    forEachActive(grid, [&](const auto& value, const openvdb::CoordBBox& of) {
        openvdb::CoordBBox common = of;
        common.intersect(inside);
        if (common.empty()) return;
        for (auto voxel = common.begin(); voxel; ++voxel) visit(toIndex(*voxel), value);
    });
}

}  // namespace

void requireAtMost(const DenseBox& box, std::size_t mostVoxels) {
    const Index3 size = box.size();
    if (double(size.x) * double(size.y) * double(size.z) <= double(mostVoxels)) return;
    throw InvalidArgument("the volume's box of " + std::to_string(size.x) + "x" + std::to_string(size.y) + "x" +
                          std::to_string(size.z) + " voxels, made dense, has more than " + std::to_string(mostVoxels) +
                          " voxels");
}

DenseBox boxAround(const openvdb::GridBase& grid, std::size_t mostVoxels) {
    const openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
    if (active.empty()) throw InvalidArgument("grid '" + grid.getName() + "' has no active voxels");
    DenseBox box;
    box.worldFromIndex = linearPart(grid);
    constexpr int kFarthest = 1 << 30;
    for (int axis = 0; axis < 3; ++axis) {
        if (active.min()[axis] < -kFarthest || active.max()[axis] > kFarthest)
            throw InvalidArgument("grid '" + grid.getName() + "' has active voxels beyond 2^30 voxels");
        box.low[axis] = blockBelow(active.min()[axis]);
        box.high[axis] = blockBelow(active.max()[axis]) + kBlock;
    }
    requireAtMost(box, mostVoxels);
    return box;
}

DenseField denseField(const openvdb::GridBase& grid, const DenseBox& box, int channel) {
    DenseField field(box.voxels(), 0.0f);
    if (grid.isType<openvdb::FloatGrid>())
        forEachInside(static_cast<const openvdb::FloatGrid&>(grid), box,
                      [&](const Index3& at, float value) { field[box.indexOf(at)] = value; });
    else if (grid.isType<openvdb::Vec3SGrid>())
        forEachInside(static_cast<const openvdb::Vec3SGrid&>(grid), box,
                      [&](const Index3& at, const openvdb::Vec3s& value) { field[box.indexOf(at)] = value[channel]; });
    else
        throw InvalidArgument("grid '" + grid.getName() + "' is of type " + grid.type() +
                              "; only float and vec3s grids can be used here");
    return field;
}

openvdb::FloatGrid::Ptr extendedGrid(const DenseField& field, const DenseBox& box, const openvdb::FloatGrid& topology) {
    DenseBox wide = box;
    wide.low -= Index3(1);
    wide.high += Index3(1);
    DenseField sum(wide.voxels(), 0.0f), count(wide.voxels(), 0.0f);
    forEachInside(topology, box, [&](const Index3& at, float) {
        for (int n = 0; n < 27; ++n) {
            const std::size_t i = wide.indexOf(at + Index3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
            sum[i] += field[box.indexOf(at)];
            count[i] += 1;
        }
    });
    forEachInside(topology, box, [&](const Index3& at, float) {
        sum[wide.indexOf(at)] = field[box.indexOf(at)];
        count[wide.indexOf(at)] = 1;
    });
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(topology.transform().copy());
    auto accessor = grid->getAccessor();
    std::size_t i = 0;
    for (int z = wide.low.z; z < wide.high.z; ++z)
        for (int y = wide.low.y; y < wide.high.y; ++y)
            for (int x = wide.low.x; x < wide.high.x; ++x, ++i)
                if (count[i] > 0) accessor.setValueOn(openvdb::Coord(x, y, z), sum[i] / count[i]);
    return grid;
}

openvdb::FloatGrid::Ptr sparseGrid(const DenseField& field, const DenseBox& box,
                                   const openvdb::math::Transform& transform) {
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(transform.copy());
    auto accessor = grid->getAccessor();
    for (int z = box.low.z; z < box.high.z; ++z)
        for (int y = box.low.y; y < box.high.y; ++y)
            for (int x = box.low.x; x < box.high.x; ++x)
                if (const float value = field[box.indexOf({x, y, z})]; value != 0)
                    accessor.setValueOn(openvdb::Coord(x, y, z), value);
    return grid;
}

}  // namespace raysweep::cube4
