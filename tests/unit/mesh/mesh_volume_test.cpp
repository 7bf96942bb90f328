// Meshes as volumes: how much of each voxel is inside, and which colour it has.
#include "raysweep/mesh/mesh_volume.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "raysweep/volume/active_values.h"
#include "support/expect_error.h"
#include "support/meshes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

/// World units.
double volumeOf(const openvdb::FloatGrid& density) {
    double sum = 0;
    forEachActive(density,
                  [&](const float& v, const openvdb::CoordBBox& box) { sum += double(v) * double(box.volume()); });
    return sum * density.transform().voxelVolume();
}

MeshVolumeOptions voxelsOf(double size) {
    MeshVolumeOptions options;
    options.voxelSize = size;
    return options;
}

}  // namespace

// Densities are exact where the surface is flat across a voxel; over a sphere what curvature makes of it nearly
// cancels: 4e-5 found at 40 voxels across.
TEST(MeshVolume, SphereHasItsVolumeAndPlace) {
    const TriangleMesh mesh = sphereMesh(Vec3(5, -3, 2), 2, 5);
    MeshVolumeOptions options;
    options.size = 40;
    const MeshVolume made = meshToVolume(mesh, options);
    EXPECT_EQ(made.solids, 1u);
    EXPECT_EQ(made.sheets + made.inwards + made.thin, 0u);
    EXPECT_FALSE(made.color);
    const double exact = made.shells.shells.at(0).volume;
    EXPECT_NEAR(volumeOf(*made.density) / exact, 1, 1e-3);
    const auto voxels = made.density->getConstAccessor();
    const auto at = [&](const openvdb::Vec3d& p) {
        return voxels.getValue(made.density->transform().worldToIndexCellCentered(p));
    };
    EXPECT_EQ(at({5, -3, 2}), 1);
    EXPECT_EQ(at({5, -3, 3.9}), 1);
    EXPECT_EQ(at({5, -3, 4.1}), 0);
}

TEST(MeshVolume, BoxOnVoxelFacesIsExact) {
    const MeshVolume made = meshToVolume(boxMesh(Vec3(-1, 0, 2), Vec3(1, 1, 4)), voxelsOf(0.25));
    EXPECT_EQ(made.density->activeVoxelCount(), 8u * 4 * 8);
    EXPECT_EQ(made.density->evalActiveVoxelBoundingBox(), openvdb::CoordBBox(0, 0, 0, 7, 3, 7));
    EXPECT_NEAR(volumeOf(*made.density), 4, 1e-5);
    const openvdb::Vec3d center = made.density->indexToWorld(openvdb::Coord(0, 0, 0));
    EXPECT_NEAR(center.x(), -0.875, 1e-12);
    EXPECT_NEAR(center.z(), 2.125, 1e-12);
}

TEST(MeshVolume, FacesWithinVoxelsCoverThemInPart) {
    const MeshVolume made = meshToVolume(boxMesh(Vec3(0), Vec3(4, 4, 4.3)), voxelsOf(1));
    EXPECT_NEAR(made.density->tree().getValue({2, 2, 4}), 0.3, 1e-3);
    EXPECT_EQ(made.density->tree().getValue({2, 2, 3}), 1);
}

TEST(MeshVolume, ShellThatFacesInwardsIsACavityWithinAnother) {
    TriangleMesh mesh = sphereMesh(Vec3(0), 2, 4);
    append(mesh, turned(sphereMesh(Vec3(0.3, 0, 0), 1, 4)));
    const MeshVolume made = meshToVolume(mesh, voxelsOf(0.1));
    EXPECT_EQ(made.solids, 1u);
    EXPECT_EQ(made.inwards, 1u);
    EXPECT_EQ(made.density->tree().getValue(made.density->transform().worldToIndexCellCentered({0.3, 0, 0})), 0);
    // 3e-4 found.
    EXPECT_NEAR(volumeOf(*made.density) / (made.shells.shells[0].volume + made.shells.shells[1].volume), 1, 2e-3);
}

TEST(MeshVolume, ShellThatFacesInwardsAloneIsFilledAndCounted) {
    const MeshVolume made = meshToVolume(turned(sphereMesh(Vec3(0), 2, 3)), voxelsOf(0.2));
    EXPECT_EQ(made.inwards, 1u);
    EXPECT_EQ(made.density->tree().getValue(made.density->transform().worldToIndexCellCentered({0, 0, 0})), 1);
}

// Distances to two faces are the same there.
TEST(MeshVolume, ConcaveEdgesBetweenVoxelsAreSharp) {
    TriangleMesh mesh;  // an L of height 2
    for (const double z : {0.0, 2.0})
        for (const auto& [x, y] : {std::pair{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}})
            mesh.positions.emplace_back(x, y, z);
    mesh.triangles = {{0, 3, 2}, {0, 2, 1}, {0, 5, 4}, {0, 4, 3}, {6, 7, 8}, {6, 8, 9}, {6, 9, 10}, {6, 10, 11}};
    for (std::uint32_t i = 0; i < 6; ++i) {
        const std::uint32_t j = (i + 1) % 6;
        mesh.triangles.push_back({i, j, j + 6});
        mesh.triangles.push_back({i, j + 6, i + 6});
    }
    for (const double voxel : {0.25, 0.2, 0.125})
        EXPECT_NEAR(volumeOf(*meshToVolume(mesh, voxelsOf(voxel)).density), 10, 1e-3) << voxel;
}

TEST(MeshVolume, SolidsThatOverlapAreOne) {
    TriangleMesh mesh = boxMesh(Vec3(0), Vec3(2));
    append(mesh, boxMesh(Vec3(1), Vec3(3)));
    EXPECT_NEAR(volumeOf(*meshToVolume(mesh, voxelsOf(0.25)).density), 15, 1e-3);
}

TEST(MeshVolume, FlippedTrianglesLeaveNoHoles) {
    TriangleMesh mesh = sphereMesh(Vec3(0), 2, 4);
    const double volume = volumeOf(*meshToVolume(mesh, voxelsOf(0.1)).density);
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
    const MeshVolume made = meshToVolume(mesh, voxelsOf(0.1));
    EXPECT_GT(made.shells.turned, 300u);
    EXPECT_NEAR(volumeOf(*made.density), volume, 1e-5);
}

TEST(MeshVolume, SheetsGetTheirThickness) {
    MeshVolumeOptions options = voxelsOf(1);
    for (const double thickness : {0.5, 1.0, 2.0, 3.5}) {
        options.thickness = thickness;
        const MeshVolume made = meshToVolume(squareMesh(32, 0.3, 4), options);
        EXPECT_EQ(made.sheets, 1u);
        double column = 0;  // in the middle of the sheet
        for (int z = -4; z < 6; ++z) column += double(made.density->tree().getValue({16, 16, z}));
        // A sheet thinner than a voxel is spread over two, each as thick as if the sheet's middle were at its face.
        EXPECT_NEAR(column, thickness, thickness < 1 ? 0.26 : 1e-4) << thickness;
    }
}

TEST(MeshVolume, SolidsAndSheetsTogether) {
    TriangleMesh mesh = boxMesh(Vec3(4, 4, 0), Vec3(8, 8, 8));
    append(mesh, squareMesh(16, 0, 1));
    const MeshVolume made = meshToVolume(mesh, voxelsOf(1));
    EXPECT_EQ(made.solids, 1u);
    EXPECT_EQ(made.sheets, 1u);
    const auto value = [&](double x, double y, double z) {
        return made.density->tree().getValue(made.density->transform().worldToIndexCellCentered({x, y, z}));
    };
    EXPECT_EQ(value(6, 6, 6), 1);
    EXPECT_EQ(value(1, 1, 0.5), 1);
    EXPECT_EQ(value(1, 1, 3.5), 0);
}

TEST(MeshVolume, ThinSolidsAreCounted) {
    EXPECT_EQ(meshToVolume(boxMesh(Vec3(0), Vec3(8, 8, 0.4)), voxelsOf(1)).thin, 1u);
    EXPECT_EQ(meshToVolume(boxMesh(Vec3(0), Vec3(8, 8, 3)), voxelsOf(1)).thin, 0u);
}

TEST(MeshVolume, ColoursAreThoseOfTheNearestPlace) {
    TriangleMesh mesh = squareMesh(16, 0, 4);
    for (const Vec3& p : mesh.positions) mesh.colors.emplace_back(float(p.x) / 16, 0.5f, 0);
    append(mesh, boxMesh(Vec3(0, 0, 6), Vec3(16, 16, 32)));  // white
    const MeshVolume made = meshToVolume(mesh, voxelsOf(1));
    ASSERT_TRUE(made.color);
    EXPECT_EQ(made.color->getName(), "Cd");
    EXPECT_EQ(made.color->background(), openvdb::Vec3s(0));
    const auto at = [&](double x, double y, double z) {
        return made.color->tree().getValue(made.color->transform().worldToIndexCellCentered({x, y, z}));
    };
    for (const double x : {2.5, 7.5, 12.5}) EXPECT_NEAR(at(x, 8.5, 0.5).x(), x / 16, 1e-5) << x;
    EXPECT_EQ(at(8.5, 8.5, 6.5), openvdb::Vec3s(1));
    // Wherever density is, and one voxel beyond.
    EXPECT_TRUE(made.color->tree().isValueOn(made.color->transform().worldToIndexCellCentered({8.5, 8.5, 20.5})));
    EXPECT_NEAR(at(8.5, 8.5, 1.5).y(), 0.5, 1e-5);
}

// A corner is as good as another: single floats would add up a million of them to a sum that is 1 % off.
TEST(MeshVolume, InsidesHaveTheMeanColourOfAllCorners) {
    TriangleMesh mesh = boxMesh(Vec3(0), Vec3(32));
    mesh.positions.resize(1000000, Vec3(0));
    mesh.colors.assign(mesh.positions.size(), Color(0.1f, 0.7f, 0.3f));
    const MeshVolume made = meshToVolume(mesh, voxelsOf(1));
    ASSERT_TRUE(made.color);
    EXPECT_EQ(made.color->tree().getValue({16, 16, 16}), openvdb::Vec3s(0.1f, 0.7f, 0.3f));
}

TEST(MeshVolume, TellsHowFarItIsAndStops) {
    TriangleMesh mesh = sphereMesh(Vec3(0), 2, 4);
    append(mesh, squareMesh(16, 0, 1));
    mesh.colors.assign(mesh.positions.size(), Color(1));
    std::vector<std::string> stages;
    const std::thread::id caller = std::this_thread::get_id();
    const MeshVolume whole = meshToVolume(mesh, voxelsOf(0.1), [&](const std::string& stage, double fraction) {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        EXPECT_TRUE(fraction >= 0 && fraction <= 1) << fraction;
        if (stages.empty() || stages.back() != stage) stages.push_back(stage);
        return true;
    });
    EXPECT_EQ(stages, (std::vector<std::string>{"distances", "insides", "distances"}));
    EXPECT_TRUE(whole.density && whole.color);
    std::size_t calls = 0, most = 0;
    const auto stopAfter = [&](const std::string&, double) { return calls++ < most; };
    for (most = 0; most < 100000; most = 2 * most + 1) {
        calls = 0;
        const MeshVolume made = meshToVolume(mesh, voxelsOf(0.1), stopAfter);
        if (calls <= most) break;  // was never told to stop
        EXPECT_FALSE(made.density) << most;
        EXPECT_EQ(calls, most + 1) << "went on";
    }
    EXPECT_GT(most, 10u);
}

TEST(MeshVolume, NamesWhatCannotBe) {
    MeshVolumeOptions options;
    options.size = 0;
    EXPECT_EQ(errorOf(options), "size 0: must be between 1 and 65536");
    options = voxelsOf(-1);
    EXPECT_EQ(errorOf(options), "voxelSize -1: must be finite and above 0");
    options = {};
    options.thickness = 0;
    EXPECT_EQ(errorOf(options), "thickness 0: must be above 0 and at most 1024 voxels");
    expectError<InvalidArgument>([] { meshToVolume(boxMesh(Vec3(0), Vec3(1e6)), voxelsOf(1)); }, "65536 voxels");
    expectError<InvalidArgument>([] { meshToVolume(boxMesh(Vec3(1), Vec3(1))); }, "no extent");
    expectError<InvalidArgument>([] { meshToVolume(boxMesh(Vec3(0), Vec3(65000)), voxelsOf(1)); }, "GB");
}
