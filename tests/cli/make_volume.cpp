/// make_volume KIND OUT.vdb: volumes for the tests of the command line that `raysweep generate` does not make, most of
/// them with something wrong. Where nothing else is said: a box of 12x10x8 voxels of 0.1 units with density 1.
#include "../support/other_grid.h"
#include "raysweep/phantoms/phantom.h"
#include "raysweep/volume/grids.h"
#include "raysweep/volume/vdb_io.h"

#include <openvdb/points/PointDataGrid.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>

namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;
using Transform = openvdb::math::Transform;
using Grids = openvdb::GridCPtrVec;

const CoordBBox kBox(Coord(0), Coord(11, 9, 7));
const Vec3d kSize(0.1);

template <class GridType>
typename GridType::Ptr filled(const std::string& name, const typename GridType::ValueType& value,
                              const Transform::Ptr& transform = Transform::createLinearTransform(kSize[0])) {
    const auto grid = GridType::create();
    grid->denseFill(kBox, value, /*active=*/true);
    grid->setName(name);
    grid->setTransform(transform);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

FloatGrid::Ptr density(const Transform::Ptr& transform = Transform::createLinearTransform(kSize[0])) {
    return filled<FloatGrid>("density", 1.0f, transform);
}

Grids withVoxel(float value) {
    const FloatGrid::Ptr grid = density();
    grid->tree().setValue(Coord(3, 4, 5), value);
    return {grid};
}

Grids withMatrix(const std::array<double, 16>& rows) {
    return {density(Transform::createLinearTransform(openvdb::Mat4d(rows.data())))};
}

Grids levelSet() {
    const auto grid = openvdb::tools::createLevelSetSphere<FloatGrid>(0.5f, Vec3s(0), 0.05f);
    grid->setName("density");
    return {grid};
}

/// Two points, in the middle of the first voxel.
Grids points() {
    const auto grid = raysweep::test::otherGrid<openvdb::points::PointDataGrid>();
    grid->setName("density");
    grid->setTransform(density()->transformPtr());
    auto* const leaf = grid->tree().touchLeaf(Coord(0));
    leaf->initializeAttributes(openvdb::points::AttributeSet::Descriptor::create({"vec3s", "null"}), 2);
    leaf->setOffsets(std::vector<openvdb::PointDataIndex32>(leaf->NUM_VALUES, 2));
    return {grid};
}

Grids noFloat() {
    const auto grid = raysweep::test::otherGrid<openvdb::Int32Grid>();
    grid->setName("ids");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setTransform(density()->transformPtr());
    for (auto at = kBox.begin(); at; ++at) grid->tree().setValueOn(*at, 3);
    return {grid};
}

/// Eight whole leaves, half of them active and empty, as simulations leave them behind.
Grids emptyLeaves() {
    const FloatGrid::Ptr grid = density();
    grid->denseFill(CoordBBox(Coord(0), Coord(31, 15, 15)), 1.0f);
    grid->denseFill(CoordBBox(Coord(16, 0, 0), Coord(31, 15, 15)), 0.0f);
    return {grid};
}

/// One tile, which is how files hold uniform regions.
Grids tile() {
    const FloatGrid::Ptr grid = FloatGrid::create();
    grid->setTransform(density()->transformPtr());
    grid->setName("density");
    grid->tree().addTile(1, Coord(0), 1.0f, true);
    return {grid};
}

Grids materials() {
    return {density(),
            filled<FloatGrid>("reflectance", 0.5f),
            filled<Vec3SGrid>("Cd", Vec3s(0.9f, 0.6f, 0.3f)),
            filled<FloatGrid>("heat", 2.0f),
            filled<Vec3SGrid>("glow", Vec3s(3, 2, 1)),
            filled<FloatGrid>("too-white", 1.5f)};
}

/// A cloud of voxels of 0.06 x 0.04 x 0.05 units, turned about an axis that is none of the grid's.
Grids turnedCloud() {
    raysweep::PhantomOptions options;
    options.size = 40;
    const FloatGrid::Ptr cloud = raysweep::makeCloud(options);
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preTranslate(Vec3d(-20, -12, -10));
    matrix.postScale(Vec3d(0.06, 0.04, 0.05));
    matrix *= openvdb::math::rotation<openvdb::Mat4d>(Vec3d(1, 2, 3).unit(), 0.7);
    matrix.postTranslate(Vec3d(3, -2, 1));
    cloud->setTransform(Transform::createLinearTransform(matrix));
    return {cloud};
}

/// A voxel at an end of the range of coordinates.
Grids withVoxelAt(const Coord& at) {
    const FloatGrid::Ptr grid = density();
    grid->tree().setValue(at, 1.0f);
    return {grid};
}

Grids uniform(float value, double edge) {
    return {filled<FloatGrid>("density", value, Transform::createLinearTransform(edge))};
}

/// Smoke from 1e-6 to 1, in an order that has no end, with fire of 1 on voxels half as long, turned about their common
/// middle by `angle` and moved along x: 24^3 of them, of 0.05 units.
Grids fire(double angle, double along) {
    const FloatGrid::Ptr smoke = density();
    for (auto on = smoke->beginValueOn(); on; ++on) {
        const Coord at = on.getCoord();
        on.setValue(std::pow(10.0f, -6 * float((at.x() * 7 + at.y() * 5 + at.z() * 3) % 11) / 10));
    }
    const auto burning = FloatGrid::create();
    burning->denseFill(CoordBBox(Coord(0), Coord(23)), 1.0f);
    burning->setName("fire");
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preTranslate(Vec3d(-11.5));
    matrix.postScale(Vec3d(0.5 * kSize[0]));
    if (angle != 0) matrix *= openvdb::math::rotation<openvdb::Mat4d>(Vec3d(1, 2, 3).unit(), angle);
    matrix.postTranslate(Vec3d(0.55 + along, 0.45, 0.35));
    burning->setTransform(Transform::createLinearTransform(matrix));
    return {smoke, burning};
}

/// The same with a voxel of fire set, or all of them.
Grids badFire(float value, bool all) {
    Grids grids = fire(0, 0);
    const auto burning = openvdb::gridConstPtrCast<FloatGrid>(grids[1])->deepCopy();
    if (all)
        burning->denseFill(CoordBBox(Coord(0), Coord(23)), value);
    else
        burning->tree().setValue(Coord(3, 4, 5), value);
    return {grids[0], burning};
}

const std::map<std::string, std::function<Grids()>> kMakers = {
    {"plain", [] { return Grids{density()}; }},
    {"materials", materials},
    {"empty", [] { return Grids{FloatGrid::create()}; }},
    {"empty-leaves", emptyLeaves},
    {"tile", tile},
    {"no-float", noFloat},
    {"no-grid", [] { return Grids{}; }},
    {"two-floats",
     [] {
         return Grids{filled<FloatGrid>("smoke", 1), filled<FloatGrid>("fuel", 1)};
     }},
    {"only-float", [] { return Grids{filled<FloatGrid>("smoke", 1)}; }},
    {"same-name",
     [] {
         return Grids{density(), filled<FloatGrid>("density", 2)};
     }},
    {"own-extinction",
     [] {
         return Grids{density(), filled<FloatGrid>("extinction", 3)};
     }},
    {"level-set", levelSet},
    {"points", points},
    {"nan", [] { return withVoxel(std::numeric_limits<float>::quiet_NaN()); }},
    {"infinite", [] { return withVoxel(std::numeric_limits<float>::infinity()); }},
    {"negative", [] { return withVoxel(-2); }},
    {"black", [] { return uniform(0, 0.1); }},
    {"at-int-max", [] { return withVoxelAt(Coord(std::numeric_limits<int>::max() - 3)); }},
    {"at-int-min", [] { return withVoxelAt(Coord(std::numeric_limits<int>::min() + 3)); }},
    {"far-apart", [] { return withVoxelAt(Coord(16000000, 0, 0)); }},
    {"far-apart-diagonal", [] { return withVoxelAt(Coord(16000000, 15000000, 14000000)); }},
    {"voxels-1e30", [] { return uniform(1, 1e30); }},
    {"points-behind",
     [] {
         return Grids{density(), points().front()};
     }},
    {"stretched",
     [] {
         return withMatrix({.1, 0, 0, 0, 0, .2, 0, 0, 0, 0, .05, 0, 1, 2, 3, 1});
     }},
    {"sheared",
     [] {
         return withMatrix({.1, 0, 0, 0, .05, .1, 0, 0, 0, .02, .1, 0, 0, 0, 0, 1});
     }},
    {"turned-cloud", turnedCloud},
    {"fire", [] { return fire(0, 0); }},
    {"turned-fire", [] { return fire(0.7, 0.4); }},
    {"fire-beside", [] { return fire(0.7, 5); }},
    {"no-fire", [] { return badFire(0, true); }},
    {"nan-fire", [] { return badFire(std::numeric_limits<float>::quiet_NaN(), false); }},
    {"frustum",
     [] {
         const openvdb::BBoxd box(Vec3d(0), Vec3d(12, 10, 8));
         return Grids{density(Transform::createFrustumTransform(box, 0.5, 1))};
     }},
};

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3 || kMakers.count(argv[1]) == 0) {
        std::fprintf(stderr, "usage: make_volume KIND OUT.vdb\n");
        return 2;
    }
    raysweep::initializeGrids();
    raysweep::writeVdb(argv[2], kMakers.at(argv[1])());
    return 0;
}
