// Volumes with opacity and colour of their own.
#include "raysweep/volume/color_volume.h"

#include "raysweep/core/error.h"
#include "support/volumes.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace raysweep;
using openvdb::Coord;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

namespace {

/// Two voxels beside each other, of densities 1 and 3, red and green, on voxels of edge 1/2.
ColorVolume twoVoxels() {
    ColorVolume volume;
    volume.density = openvdb::FloatGrid::create(0.0f);
    volume.density->setName("density");
    volume.density->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    volume.color = Vec3SGrid::create(Vec3s(0.0f));
    volume.color->setTransform(volume.density->transform().copy());
    volume.density->tree().setValue(Coord(7, 0, 0), 1);
    volume.density->tree().setValue(Coord(8, 0, 0), 3);
    volume.color->tree().setValue(Coord(7, 0, 0), Vec3s(1, 0, 0));
    volume.color->tree().setValue(Coord(8, 0, 0), Vec3s(0, 1, 0));
    return volume;
}

}  // namespace

TEST(ColorVolume, OpacityIsThatOfAVoxelEdge) {
    const auto opacity = opacityGrid(*twoVoxels().density);
    EXPECT_EQ(opacity->getName(), "opacity");
    EXPECT_EQ(opacity->activeVoxelCount(), 2u);
    EXPECT_FLOAT_EQ(opacity->tree().getValue(Coord(7, 0, 0)), float(1 - std::exp(-0.5)));
    EXPECT_FLOAT_EQ(opacity->tree().getValue(Coord(8, 0, 0)), float(1 - std::exp(-1.5)));
}

TEST(ColorVolume, ColoursAreContinuedByTheMeanOfWhatIsBeside) {
    const ColorVolume volume = twoVoxels();
    const auto color = extendedColor(*volume.color, *volume.density);
    EXPECT_EQ(color->activeVoxelCount(), 4u * 3 * 3);
    const auto at = [&](int x, int y, int z) { return color->tree().getValue(Coord(x, y, z)); };
    EXPECT_EQ(at(7, 0, 0), Vec3s(1, 0, 0));
    EXPECT_EQ(at(6, 1, -1), Vec3s(1, 0, 0));
    EXPECT_EQ(at(9, 0, 0), Vec3s(0, 1, 0));
    EXPECT_EQ(at(7, 1, 0), Vec3s(0.25f, 0.75f, 0));
    EXPECT_EQ(at(5, 0, 0), Vec3s(0.0f));
    volume.color->setTransform(openvdb::math::Transform::createLinearTransform(1));
    EXPECT_THROW(extendedColor(*volume.color, *volume.density), InvalidArgument);
}

TEST(ColorVolume, GridsSayWhatTheyAre) {
    ColorVolume volume = twoVoxels();
    EXPECT_EQ(gridsOf(volume).size(), 3u);
    volume.confidence = test::namedBox("confidence", 1);
    volume.views = test::namedBox("views", 1);
    const VdbFile file{"", gridsOf(volume), {}};
    ASSERT_EQ(file.grids.size(), 5u);
    EXPECT_EQ(file.grids[0]->getName(), "density");
    EXPECT_EQ(file.grids[1]->getName(), "opacity");
    EXPECT_EQ(colorGrid(file), volume.color);
    EXPECT_EQ(volume.color->metaValue<std::string>("raysweep_density"), "density");
    EXPECT_EQ(volume.color->metaValue<double>("raysweep_extinction"), 1);
    EXPECT_EQ(colorGrid({"", {test::namedBox("Cd", 1)}, {}}), nullptr);  // no colours but numbers
}

TEST(ColorVolume, PowerSumsOverVoxels) {
    const ColorPower power = powerOf(twoVoxels());
    const double a = 1 - std::exp(-0.5), b = 1 - std::exp(-1.5);
    EXPECT_NEAR(power.opacity, a * a + b * b, 1e-7);  // opacities are floats
    EXPECT_NEAR(power.color, (a * a + b * b) / 3, 1e-7);
}
