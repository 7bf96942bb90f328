// A lit file is shown as it was lit, unless it is said otherwise.
#include "raysweep/render/lit_volume.h"

#include "raysweep/core/error.h"
#include "raysweep/scene/lit_file.h"
#include "raysweep/volume/color_volume.h"
#include "raysweep/volume/cycles_export.h"
#include "support/temporary_folder.h"
#include "support/volumes.h"

#include <gtest/gtest.h>

using namespace raysweep;
using openvdb::Coord;

namespace {

/// Two grids, of which "smoke" was lit; every voxel has radiosity 2 and the unshot power 4 pi.
VdbFile litFile(const MediumOptions& medium) {
    const test::TemporaryFolder folder;
    const VdbFile input{"in.vdb", {test::namedBox("fire", 5), test::namedBox("smoke", 1)}, {}};
    SceneOptions options;
    options.medium = medium;
    options.medium.density = "smoke";
    writeLit(folder / "lit.vdb", input, sceneFrom(input, options), {"", "medium", 1, false},
             {test::namedBox("radiosity", 2), test::namedBox("unshot", float(4 * kPi))});
    return readVdb(folder / "lit.vdb");
}

VdbFile litFog() {
    MediumOptions options;
    options.extinction = 3;
    return litFile(options);
}

VdbFile litSolid() {
    MediumOptions options;
    options.classification = Classification{rampFunction(0, 1), "0,1", ""};
    return litFile(options);
}

InvalidArgument errorOf(const VdbFile& file, const LitVolumeOptions& options = {}) {
    try {
        litVolume(file, options);
    } catch (const InvalidArgument& e) {
        return e;
    }
    return InvalidArgument("no error");
}

}  // namespace

TEST(LitVolume, OfAFogIsTheDensityThatWasLit) {
    const RenderInput input = litVolume(litFog());
    EXPECT_EQ(input.density->getName(), "smoke");
    EXPECT_EQ(input.extinctionScale, 3);
    EXPECT_EQ(input.radiosity->getName(), "radiosity");
}

TEST(LitVolume, OfASolidIsTheExtinctionThatWasWritten) {
    const RenderInput input = litVolume(litSolid());
    EXPECT_EQ(input.density->getName(), "extinction");
    EXPECT_EQ(input.extinctionScale, 1);
}

TEST(LitVolume, WhatIsSaidWins) {
    LitVolumeOptions options;
    options.density = "fire";
    options.extinction = 0.5;
    for (const VdbFile& file : {litFog(), litSolid()}) {
        const RenderInput input = litVolume(file, options);
        EXPECT_EQ(input.density->getName(), "fire");
        EXPECT_EQ(input.extinctionScale, 0.5);
    }
    LitVolumeOptions classified;
    classified.transfer = rampFunction(0, 1);
    const RenderInput input = litVolume(litFog(), classified);
    EXPECT_EQ(input.extinctionScale, 1);
    EXPECT_NEAR(input.density->tree().getValue(Coord(1, 1, 1)), extinctionFromOpacity(kRampOpacity, 1), 1e-5);
}

TEST(LitVolume, ShowsUnshotPowerAsLightOfAColour) {
    LitVolumeOptions options;
    options.unshot = Color(1, 0, 0.5f);
    const RenderInput input = litVolume(litFog(), options);
    const auto sum = openvdb::gridConstPtrCast<openvdb::Vec3SGrid>(input.radiosity);
    ASSERT_TRUE(sum);
    // 4 pi W from a voxel whose edge is 1, over pi and that edge's square
    EXPECT_TRUE(sum->tree().getValue(Coord(1, 1, 1)).eq(openvdb::Vec3f(2 + 4, 2, 2 + 2), 1e-6f));
}

TEST(LitVolume, OfAVolumeWithColoursShowsThemUnlessItWasLit) {
    ColorVolume volume;
    volume.density = test::namedBox("density", 3);
    volume.color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.5f));
    const VdbFile file{"colours.vdb", gridsOf(volume), {}};
    const RenderInput input = litVolume(file);
    EXPECT_EQ(input.density->getName(), "density");
    EXPECT_EQ(input.extinctionScale, 1);
    EXPECT_EQ(input.radiosity, volume.color);
    LitVolumeOptions options;
    options.density = "opacity";
    options.extinction = 7;
    EXPECT_EQ(litVolume(file, options).density->getName(), "opacity");
    EXPECT_EQ(litVolume(file, options).extinctionScale, 7);
    VdbFile lit = litFog();
    lit.grids.push_back(volume.color);
    EXPECT_EQ(litVolume(lit).radiosity->getName(), "radiosity");
    // A number is no colour.
    const VdbFile numbers{"numbers.vdb", {volume.density, test::namedBox("Cd", 1)}, {}};
    EXPECT_EQ(errorOf(numbers).remedy, Remedy::lightFirst);
}

TEST(LitVolume, UnshotPowerMustBeOnTheVoxelsOfRadiosity) {
    const VdbFile file = litFog();
    for (const auto& grid : file.grids)
        if (grid->getName() == "unshot") grid->setTransform(openvdb::math::Transform::createLinearTransform(2));
    LitVolumeOptions options;
    options.unshot = grey(1);
    EXPECT_EQ(errorOf(file, options).remedy, Remedy::keepVoxels);
}

TEST(LitVolume, SaysWhatMustBeDoneFirst) {
    const InvalidArgument dark = errorOf({"dark.vdb", {test::namedBox("smoke", 1)}, {}});
    EXPECT_EQ(dark.remedy, Remedy::lightFirst);
    EXPECT_EQ(dark.subject, "dark.vdb");
    VdbFile moved = litFog();
    moveForCycles(moved);
    EXPECT_EQ(errorOf(moved).remedy, Remedy::useOriginal);
}

TEST(LitVolumeOptions, NameFieldValueAndBound) {
    LitVolumeOptions options;
    options.extinction = -1;
    EXPECT_STREQ(errorOf(litFog(), options).what(), "extinction -1: must be finite and not negative");
    options.extinction.reset();
    options.unshot = Color(0, -2, 0);
    EXPECT_STREQ(errorOf(litFog(), options).what(), "unshot -2: must be finite and not negative");
}
