// Radiosity on meshes.
#include "raysweep/render/bake.h"

#include <gtest/gtest.h>

#include "raysweep/mesh/mesh_volume.h"
#include "raysweep/volume/active_values.h"
#include "support/expect_error.h"
#include "support/meshes.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr double kDense = 4.6;  ///< per voxel: opacity 0.99

/// The volume of a mesh with S = 1 + x/100 everywhere.
RenderInput volumeOf(const TriangleMesh& mesh, double voxel) {
    MeshVolumeOptions options;
    options.voxelSize = voxel;
    const openvdb::FloatGrid::Ptr density = meshToVolume(mesh, options).density;
    const openvdb::FloatGrid::Ptr radiosity = openvdb::FloatGrid::create(0);
    radiosity->setTransform(density->transform().copy());
    const openvdb::CoordBBox box = density->evalActiveVoxelBoundingBox().expandBy(2), &all = box;
    auto to = radiosity->getAccessor();
    for (const openvdb::Coord& at : all) to.setValue(at, float(1 + density->indexToWorld(at).x() / 100));
    return {density, kDense / voxel, radiosity};
}

}  // namespace

// The eye looks half a voxel deep (opacity 0.99 a voxel), which on a sphere of 20 voxels moves it by 1e-3 of S.
TEST(Bake, CornersOfASphereTakeWhatIsAtTheirPlaces) {
    const TriangleMesh mesh = sphereMesh(Vec3(7, 1, 2), 20, 4);
    const BakedMesh baked = bakeRadiosity(volumeOf(mesh, 1), mesh);
    EXPECT_TRUE(baked.complete);
    EXPECT_EQ(baked.corners.places, mesh.positions.size());
    EXPECT_EQ(baked.corners.turned + baked.corners.missed, 0u);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        ASSERT_NEAR(baked.mesh.colors[i].x, 1 + mesh.positions[i].x / 100, 0.006) << i;
}

TEST(Bake, MeshThatFacesInwardsIsSeenFromOutside) {
    const TriangleMesh mesh = turned(sphereMesh(Vec3(0), 10, 3));
    const BakedMesh baked = bakeRadiosity(volumeOf(mesh, 1), mesh);
    EXPECT_EQ(baked.corners.turned, mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        ASSERT_NEAR(baked.mesh.colors[i].x, 1 + mesh.positions[i].x / 100, 0.006) << i;
}

TEST(Bake, WhereThereIsNoVolumeItIsBlackAndCounted) {
    const TriangleMesh mesh = sphereMesh(Vec3(0), 10, 3);
    const BakedMesh baked = bakeRadiosity(volumeOf(mesh, 1), sphereMesh(Vec3(100, 0, 0), 10, 3));
    EXPECT_EQ(baked.corners.missed, mesh.positions.size());
    EXPECT_EQ(baked.mesh.colors.at(5), Color(0, 0, 0));
}

TEST(Bake, AtlasHasTheSurfaceWhereTheTextureCoordinatesPutIt) {
    const TriangleMesh mesh = squareMesh(16, 4, 2);
    BakeOptions options;
    options.atlas = 64;
    const BakedMesh baked = bakeRadiosity(volumeOf(mesh, 1), mesh, options);
    ASSERT_EQ(baked.atlas.width, 64);
    EXPECT_EQ(baked.texels.places, 64u * 64);
    // Not within a voxel of the rim, where the sheet ends.
    for (int y = 6; y < 58; ++y)
        for (int x = 6; x < 58; ++x) ASSERT_NEAR(baked.atlas.at(x, y)[0], 1 + (x + 0.5) / 400, 1e-4) << x << "," << y;
}

TEST(Bake, AtlasGoesOnBesideTheTriangles) {
    TriangleMesh mesh = squareMesh(16, 4, 2);
    for (auto& uv : mesh.texture) uv = {0.25f + uv[0] / 2, 0.25f + uv[1] / 2};
    BakeOptions options;
    options.atlas = 32;
    const BakedMesh baked = bakeRadiosity(volumeOf(mesh, 1), mesh, options);
    EXPECT_EQ(baked.texels.places, 16u * 16);
    EXPECT_GT(baked.atlas.at(16, 5)[0], 0.5);
    EXPECT_EQ(baked.atlas.at(16, 2)[0], 0);
    EXPECT_GT(baked.atlas.at(16, 26)[0], 0.5);
}

TEST(Bake, NamesWhatCannotBe) {
    const TriangleMesh mesh = sphereMesh(Vec3(0), 4, 1);
    BakeOptions options;
    options.atlas = -1;
    EXPECT_EQ(errorOf(options), "atlas -1: must be between 0 and 32768 pixels");
    options.atlas = 8;
    expectError<InvalidArgument>([&] { bakeRadiosity(volumeOf(mesh, 1), mesh, options); }, "texture coordinates");
}
