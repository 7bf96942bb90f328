// Meshes in files, written here by hand.
#include "raysweep/mesh/mesh_files.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"
#include "raysweep/mesh/mesh_shells.h"
#include "support/expect_error.h"
#include "support/meshes.h"
#include "support/temporary_folder.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

std::string written(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
    return path;
}

const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n"
    "0 0 0 255 0 0\n2 0 0 0 255 0\n2 2 0 0 0 255\n0 2 0 128 128 128\n4 0 1 2 3\n";

/// A binary STL of one triangle.
std::string stl() {
    std::string bytes(80, ' ');
    const auto add = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    add(std::uint32_t(1));
    for (const float v : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) add(v);
    add(std::uint16_t(0));
    return bytes;
}

}  // namespace

TEST(MeshFiles, ObjWithPolygonsTextureAndSeveralObjects) {
    const TemporaryFolder folder;
    const TriangleMesh mesh = readMesh(
        written(folder / "a.obj",
                "o first\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
                "o second\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n"));
    EXPECT_EQ(mesh.triangles.size(), 3u);
    EXPECT_TRUE(mesh.colors.empty());
    const MeshShells shells = shellsOf(mesh);
    ASSERT_EQ(shells.shells.size(), 2u);
    EXPECT_DOUBLE_EQ(shells.shells[0].area + shells.shells[1].area, 1.5);
    ASSERT_EQ(mesh.texture.size(), mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        if (mesh.positions[i].z == 0) {
            EXPECT_FLOAT_EQ(mesh.texture[i][0], float(mesh.positions[i].x));
            EXPECT_FLOAT_EQ(mesh.texture[i][1], float(mesh.positions[i].y));
        }
}

TEST(MeshFiles, ObjColoursOfCornersOrOfMaterials) {
    const TemporaryFolder folder;
    const TriangleMesh own =
        readMesh(written(folder / "a.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n"));
    ASSERT_EQ(own.colors.size(), 3u);
    EXPECT_EQ(own.colors[0], Color(1, 0, 0));
    written(folder / "b.mtl", "newmtl wall\nKd 0 0.5 1\n");
    const std::string path =
        written(folder / "b.obj", "mtllib b.mtl\nusemtl wall\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_EQ(readMesh(path, ColorEncoding::linear).colors.at(0), Color(0, 0.5f, 1));
    EXPECT_FLOAT_EQ(readMesh(path).colors.at(0).y, linearFromSrgb(0.5f));
}

TEST(MeshFiles, PlyWithColours) {
    const TemporaryFolder folder;
    const TriangleMesh mesh = readMesh(written(folder / "a.ply", kPly));
    EXPECT_EQ(mesh.triangles.size(), 2u);
    ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        if (mesh.positions[i] == Vec3(0)) {
            EXPECT_EQ(mesh.colors[i], Color(1, 0, 0));
        }
        if (mesh.positions[i] == Vec3(0, 2, 0)) {
            EXPECT_NEAR(mesh.colors[i].x, linearFromSrgb(128 / 255.f), 1e-6);
        }
    }
}

TEST(MeshFiles, StlInBothForms) {
    const TemporaryFolder folder;
    for (const std::string& text :
         {stl(), std::string("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                             "endloop\nendfacet\nendsolid a\n")}) {
        const TriangleMesh mesh = readMesh(written(folder / "a.STL", text));
        EXPECT_EQ(mesh.triangles.size(), 1u);
        EXPECT_DOUBLE_EQ(shellsOf(mesh).shells.at(0).area, 0.5);
        EXPECT_TRUE(mesh.colors.empty());
    }
}

TEST(MeshFiles, PlyIsReadBackAsItWasWritten) {
    const TemporaryFolder folder;
    TriangleMesh mesh = squareMesh(2, 1, 2);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) mesh.colors.emplace_back(0.1f * float(i), 0.5f, 0.25f);
    writePly(folder / "a.ply", mesh, ColorEncoding::linear);
    const TriangleMesh back = readMesh(folder / "a.ply", ColorEncoding::linear);
    EXPECT_EQ(back.positions.size(), mesh.positions.size());
    EXPECT_EQ(back.triangles.size(), mesh.triangles.size());
    for (std::size_t i = 0; i < back.positions.size(); ++i) {
        const auto at =
            std::find(mesh.positions.begin(), mesh.positions.end(), back.positions[i]) - mesh.positions.begin();
        EXPECT_EQ(back.colors[i], mesh.colors[std::size_t(at)]);
        EXPECT_EQ(back.texture[i], mesh.texture[std::size_t(at)]);
    }
    writePly(folder / "b.ply", mesh);  // bytes
    const TriangleMesh shown = readMesh(folder / "b.ply");
    EXPECT_EQ(shown.positions.size(), mesh.positions.size());
    for (const Color& color : shown.colors) EXPECT_NEAR(color.y, 0.5, 0.003);  // half a step of 255 is 0.0024
    expectError<InvalidArgument>([&] { writePly(folder / "a.obj", mesh); }, "written as .ply");
}

TEST(MeshFiles, RefusesWhatIsNoMesh) {
    const TemporaryFolder folder;
    const auto refuses = [&](const std::string& path, const std::string& why) {
        expectError<IoError>([&] { readMesh(path); }, why);
    };
    refuses(folder / "none.obj", "no such file");
    refuses(folder.path().string(), "it is a folder");
    refuses(written(folder / "a.txt", "v 0 0 0"), ".obj, .ply or .stl");
    refuses(written(folder / "empty.obj", ""), "cannot read");
    refuses(written(folder / "points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), "cannot read");
    refuses(written(folder / "nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "no finite number");
    refuses(written(folder / "cut.ply", kPly.substr(0, kPly.size() - 30)), "cannot read");
    refuses(written(folder / "cut.stl", stl().substr(0, 100)), "cannot read");
    refuses(written(folder / "far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n"), "cannot read");
    refuses(written(folder / "other.stl", kPly), "cannot read");
    std::filesystem::create_symlink("/dev/zero", folder / "endless.ply");
    refuses(folder / "endless.ply", "a device or a pipe");
}
