#include "raysweep/volume/directional_color.h"

#include <gtest/gtest.h>

#include "raysweep/volume/color_volume.h"

using namespace raysweep;
using openvdb::Coord;
using openvdb::Vec3s;

namespace {

openvdb::Vec3SGrid::Ptr gridOf(const char* name, const Vec3s& value) {
    const auto grid = openvdb::Vec3SGrid::create(Vec3s(0.0f));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->tree().setValue(Coord(4, 0, 0), value);
    grid->setName(name);
    return grid;
}

DirectionalColor oneVoxel() {
    return {gridOf("Cd_0", Vec3s(0.4f, 0.3f, 0.1f)), gridOf("Cd_x", Vec3s(0.1f, 0, -0.5f)),
            gridOf("Cd_y", Vec3s(0, 0.2f, 0)), gridOf("Cd_z", Vec3s(0, 0, 0.7f))};
}

}  // namespace

// A voxel at (2,0,0), seen along x, along -y, and in parallel along z, wherever that camera is.
TEST(DirectionalColor, AlongTheRayToTheVoxel) {
    const DirectionalColor color = oneVoxel();
    const auto seenFrom = [&](const Vec3& place, Camera::Projection projection, const Vec3& forward) {
        PhotoCamera camera;
        camera.projection = projection;
        camera.position = place;
        camera.forward = forward;
        return colorSeenFrom(color, camera)->tree().getValue(Coord(4, 0, 0));
    };
    const auto near = [](const Vec3s& a, const Vec3s& b) { return (a - b).length() < 1e-6f; };
    using Projection = Camera::Projection;
    EXPECT_TRUE(near(seenFrom(Vec3(-3, 0, 0), Projection::Perspective, Vec3(0, 1, 0)), Vec3s(0.5f, 0.3f, 0)));
    EXPECT_TRUE(near(seenFrom(Vec3(2, 5, 0), Projection::Perspective, Vec3(0, 1, 0)), Vec3s(0.4f, 0.1f, 0.1f)));
    EXPECT_TRUE(near(seenFrom(Vec3(9, 9, 9), Projection::Orthographic, Vec3(0, 0, 1)), Vec3s(0.4f, 0.3f, 0.8f)));
}

TEST(DirectionalColor, GoesIntoTheFile) {
    ColorVolume volume{openvdb::FloatGrid::create(0), gridOf("Cd", Vec3s(1.0f))};
    volume.directional = oneVoxel();
    const openvdb::GridPtrVec grids = gridsOf(volume);
    ASSERT_EQ(grids.size(), 7u);
    EXPECT_EQ(grids[3]->getName(), "Cd_0");
    EXPECT_EQ(grids[6]->getName(), "Cd_z");
}
