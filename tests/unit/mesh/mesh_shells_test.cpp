// What meshes are made of.
#include "raysweep/mesh/mesh_shells.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/meshes.h"

using namespace raysweep;
using namespace raysweep::test;

TEST(MeshShells, BoxIsClosedAndHasItsVolumeAndArea) {
    const MeshShells found = shellsOf(boxMesh(Vec3(1, 2, 3), Vec3(2, 4, 6)));
    ASSERT_EQ(found.shells.size(), 1u);
    EXPECT_TRUE(found.shells[0].closed);
    EXPECT_DOUBLE_EQ(found.shells[0].volume, 6);
    EXPECT_DOUBLE_EQ(found.shells[0].area, 2 * (2 + 3 + 6));
    EXPECT_EQ(found.openEdges + found.holes + found.forkedEdges + found.turned + found.degenerate, 0u);
}

TEST(MeshShells, BoxThatFacesInwardsHasANegativeVolume) {
    const MeshShells found = shellsOf(turned(boxMesh(Vec3(0), Vec3(2))));
    EXPECT_DOUBLE_EQ(found.shells.at(0).volume, -8);
    EXPECT_EQ(found.turned, 0u);
}

TEST(MeshShells, MissingTrianglesLeaveAHole) {
    TriangleMesh mesh = boxMesh(Vec3(0), Vec3(1));
    mesh.triangles.erase(mesh.triangles.begin() + 4);  // of one side,
    mesh.triangles.erase(mesh.triangles.begin());      // and of the opposite one
    const MeshShells found = shellsOf(mesh);
    EXPECT_FALSE(found.shells.at(0).closed);
    EXPECT_EQ(found.openEdges, 6u);
    EXPECT_EQ(found.holes, 1u) << "the two share a corner";
    mesh = squareMesh(1, 0, 3);
    append(mesh, squareMesh(1, 5, 2));
    const MeshShells sheets = shellsOf(mesh);
    EXPECT_EQ(sheets.shells.size(), 2u);
    EXPECT_EQ(sheets.openEdges, 12u + 8u);
    EXPECT_EQ(sheets.holes, 2u);
}

TEST(MeshShells, FlippedTrianglesAreFoundAndTurned) {
    TriangleMesh mesh = sphereMesh(Vec3(0), 1, 2);
    const double volume = shellsOf(mesh).shells.at(0).volume;
    for (const std::size_t i : {0u, 7u, 8u, 100u}) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
    const MeshShells found = shellsOf(mesh);
    EXPECT_EQ(found.turned, 4u);
    EXPECT_TRUE(found.shells.at(0).closed);
    EXPECT_NEAR(found.shells[0].volume, volume, 1e-12);
    const MeshShells alike = shellsOf(facingAlike(mesh, found));
    EXPECT_EQ(alike.turned, 0u);
    EXPECT_NEAR(alike.shells.at(0).volume, volume, 1e-12);
}

TEST(MeshShells, StripWithOneSideOnlyIsNotClosed) {
    TriangleMesh strip;  // a Moebius strip of 8 squares
    for (int i = 0; i < 8; ++i) {
        const double turn = kPi * i / 4, twist = turn / 2;
        for (const double r : {-0.3, 0.3})
            strip.positions.emplace_back((1 + r * std::cos(twist)) * std::cos(turn),
                                         (1 + r * std::cos(twist)) * std::sin(turn), r * std::sin(twist));
    }
    for (std::uint32_t i = 0; i < 8; ++i) {
        const std::uint32_t a = 2 * i, b = a + 1, c = i < 7 ? a + 2 : 1, d = i < 7 ? a + 3 : 0;
        strip.triangles.push_back({a, c, b});
        strip.triangles.push_back({b, c, d});
    }
    const MeshShells found = shellsOf(strip);
    EXPECT_EQ(found.shells.size(), 1u);
    EXPECT_EQ(found.holes, 1u);
    EXPECT_FALSE(found.shells[0].closed);
}

TEST(MeshShells, CornersInOnePlaceAreOneAndTrianglesWithoutAreaNone) {
    TriangleMesh split;  // as files have it that give each triangle corners of its own
    const TriangleMesh box = boxMesh(Vec3(0), Vec3(1));
    for (const TriangleMesh::Triangle& t : box.triangles) {
        const auto first = std::uint32_t(split.positions.size());
        for (const std::uint32_t corner : t) split.positions.push_back(box.positions[corner]);
        split.triangles.push_back({first, first + 1, first + 2});
    }
    split.triangles.push_back({0, 1, 1});
    const MeshShells found = shellsOf(split);
    EXPECT_EQ(found.shells.size(), 1u);
    EXPECT_TRUE(found.shells.at(0).closed);
    EXPECT_EQ(found.degenerate, 1u);
}

TEST(MeshShells, FinOnABoxLeavesTheBoxClosed) {
    TriangleMesh mesh = boxMesh(Vec3(0), Vec3(1));
    mesh.positions.emplace_back(2, 0, 0);
    mesh.triangles.push_back({1, 3, 8});  // on an edge that two triangles of the box have
    const MeshShells found = shellsOf(mesh);
    EXPECT_EQ(found.forkedEdges, 1u);
    ASSERT_EQ(found.shells.size(), 2u);
    EXPECT_TRUE(found.shells[0].closed);
    EXPECT_FALSE(found.shells[1].closed);
}

TEST(MeshShells, NormalsAreSmoothOnASphereAndKeepTheEdgesOfABox) {
    const TriangleMesh sphere = sphereMesh(Vec3(3, 0, 0), 2, 3);
    const std::vector<Vec3> normals = cornerNormals(sphere);
    for (std::size_t i = 0; i < normals.size(); ++i)
        EXPECT_GT(normals[i].dot((sphere.positions[i] - Vec3(3, 0, 0)).normalized()), 0.9997);  // 1.2 degrees found
    TriangleMesh edge = squareMesh(1, 0, 1);  // and a wall on its side, with corners of its own
    TriangleMesh wall = squareMesh(1, 0, 1);
    for (Vec3& p : wall.positions) p = Vec3(0, p.y, p.x);
    append(edge, wall);
    const std::vector<Vec3> kept = cornerNormals(edge);
    EXPECT_NEAR(kept[0].z, 1, 1e-12);
    EXPECT_NEAR(std::abs(kept[4].x), 1, 1e-12);
}
