#include "raysweep/volume/cycles_export.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

using namespace raysweep;
using openvdb::Vec3d;

namespace {

openvdb::FloatGrid::Ptr gridOf(const std::string& name, const openvdb::math::Transform::Ptr& transform) {
    const auto grid = openvdb::FloatGrid::create();
    grid->setName(name);
    grid->setTransform(transform);
    return grid;
}

}  // namespace

TEST(MoveForCycles, MovesEachGridByHalfAVoxelOfItsOwn) {
    using openvdb::math::Transform;
    const auto fine = gridOf("density", Transform::createLinearTransform(0.5));
    const auto coarse = gridOf("radiosity", Transform::createLinearTransform(2));
    const auto frustum =
        gridOf("view", Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(10)), 0.5, 10));
    VdbFile file{"some.vdb", {fine, coarse, frustum}, {}};
    EXPECT_NO_THROW(requireOriginal(file));
    EXPECT_EQ(moveForCycles(file), std::vector<std::string>{"view"});
    EXPECT_EQ(fine->indexToWorld(Vec3d(1)), Vec3d(0.25));
    EXPECT_EQ(coarse->indexToWorld(Vec3d(1)), Vec3d(1));
}

TEST(MoveForCycles, DoesSoOnce) {
    VdbFile file{"some.vdb", {gridOf("density", openvdb::math::Transform::createLinearTransform(1))}, {}};
    moveForCycles(file);
    try {
        moveForCycles(file);
        FAIL() << "no error";
    } catch (const InvalidArgument& e) {
        EXPECT_EQ(e.remedy, Remedy::useOriginal);
    }
}
