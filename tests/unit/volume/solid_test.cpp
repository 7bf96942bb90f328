#include "raysweep/volume/solid.h"

#include "raysweep/core/error.h"
#include "raysweep/core/types.h"
#include "raysweep/volume/grid_select.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <gtest/gtest.h>

using namespace raysweep;
using openvdb::FloatGrid;

namespace {

FloatGrid::Ptr ball(float radius, float voxel) {
    return openvdb::tools::createLevelSetSphere<FloatGrid>(radius, openvdb::Vec3f(0.03f, 0.01f, -0.02f), voxel);
}

}  // namespace

TEST(Solid, OfALevelSetHasItsVolumeAndAnEdgeOfOneVoxel) {
    const double R = 2, h = 0.1;
    const FloatGrid::Ptr levelSet = ball(float(R), float(h)), solid = levelSetToSolid(*levelSet);
    double volume = 0;
    for (auto it = solid->cbeginValueOn(); it; ++it) {
        EXPECT_GT(*it, 0);
        EXPECT_LE(*it, 1);
        volume += double(*it) * double(it.getVoxelCount()) * h * h * h;
        const double distance = (solid->indexToWorld(it.getCoord()) - openvdb::Vec3d(0.03, 0.01, -0.02)).length();
        if (!it.isVoxelValue()) continue;
        EXPECT_NEAR(*it, std::min(1.0, 0.5 - (distance - R) / h), 1e-4);  // distances are floats
    }
    // A ramp one voxel wide around R integrates to 4/3 pi (R^3 + R h^2/4); a lattice of it to about 1e-4 of that.
    EXPECT_NEAR(volume / (4.0 / 3 * kPi * (R * R * R + R * h * h / 4)), 1, 3e-4);
    EXPECT_EQ(solid->tree().getValue(openvdb::Coord(0)), 1);
    EXPECT_EQ(solid->background(), 0);
    EXPECT_EQ(levelSet->getGridClass(), openvdb::GRID_LEVEL_SET) << "the argument stays as it is";
    EXPECT_LT(levelSet->tree().getValue(openvdb::Coord(0)), 0);
}

TEST(Solid, IsChosenFromFogAndLevelSets) {
    VdbFile file{"file.vdb", {ball(1, 0.1f)}, {}};
    file.grids[0]->setName("surface");
    const FloatGrid::Ptr solid = selectSolid(file);
    EXPECT_EQ(solid->tree().getValue(openvdb::Coord(0)), 1);
    EXPECT_EQ(solid->getGridClass(), openvdb::GRID_FOG_VOLUME);

    const FloatGrid::Ptr fog = FloatGrid::create(0.0f);
    fog->setName("density");
    file.grids.push_back(fog);
    EXPECT_EQ(selectSolid(file), fog);
    EXPECT_EQ(selectSolid(file, "surface")->tree().getValue(openvdb::Coord(0)), 1);
    EXPECT_THROW(selectSolid(file, "other"), InvalidArgument);
}

TEST(Solid, NeedsAnInside) {
    const FloatGrid::Ptr empty = FloatGrid::create(0.3f);
    empty->setGridClass(openvdb::GRID_LEVEL_SET);
    EXPECT_THROW(selectSolid(VdbFile{"file.vdb", {empty}, {}}), InvalidArgument);
}
