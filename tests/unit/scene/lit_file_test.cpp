// What is written about a lit volume is what is read again.
#include "raysweep/scene/lit_file.h"

#include "raysweep/core/error.h"
#include "support/temporary_folder.h"
#include "support/volumes.h"

#include <gtest/gtest.h>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

std::string metaOf(const openvdb::GridBase& grid, const std::string& key) {
    const auto value = grid[key];
    return value ? value->str() : "none";
}

/// Writes `input` as lit with `options`, and reads it again.
VdbFile lit(const VdbFile& input, const MediumOptions& options) {
    const test::TemporaryFolder folder;
    SceneOptions scene;
    scene.medium = options;
    const LitRecord record{"quiet=true\n", "medium", 0.5, false};
    EXPECT_TRUE(
        writeLit(folder / "lit.vdb", input, sceneFrom(input, scene), record, {test::namedBox("radiosity", 7)}).empty());
    return readVdb(folder / "lit.vdb");
}

}  // namespace

TEST(LitFile, OfAFogSaysDensityAndExtinction) {
    MediumOptions options;
    options.extinction = 3;
    const VdbFile file = lit({"in.vdb", {test::namedBox("smoke", 1)}, {}}, options);
    ASSERT_EQ(file.grids.size(), 2u);
    const auto radiosity = litRadiosity(file);
    ASSERT_TRUE(radiosity);
    EXPECT_EQ(litDensity(*radiosity), "smoke");
    EXPECT_EQ(litExtinctionScale(*radiosity), 3);
    EXPECT_FALSE(litExtinction(file));
    EXPECT_EQ(metaOf(*radiosity, "raysweep_options"), "quiet=true\n");
    EXPECT_EQ(metaOf(*radiosity, "raysweep_exchange"), "medium");
    EXPECT_EQ(metaOf(*radiosity, "raysweep_resolution"), "0.5");
    EXPECT_EQ(metaOf(*radiosity, "raysweep_ramp"), "none");
    EXPECT_EQ(metaOf(*radiosity, "raysweep_transfer"), "none");
}

TEST(LitFile, OfASolidHoldsTheExtinctionAndTheRamp) {
    MediumOptions options;
    options.classification = Classification{rampFunction(0, 1), "0,1", ""};
    const VdbFile file = lit({"in.vdb", {test::namedBox("ct", 1)}, {}}, options);
    ASSERT_EQ(file.grids.size(), 3u);
    const FloatGrid::Ptr extinction = litExtinction(file);
    ASSERT_TRUE(extinction);
    EXPECT_NEAR(extinction->tree().getValue(Coord(1, 1, 1)), extinctionFromOpacity(kRampOpacity, 1), 1e-5);
    EXPECT_EQ(litExtinctionScale(*litRadiosity(file)), 1);
    EXPECT_EQ(metaOf(*extinction, "raysweep_ramp"), "0,1");
    const VdbFile rest = withoutLight(file);
    ASSERT_EQ(rest.grids.size(), 1u);
    EXPECT_EQ(rest.grids[0]->getName(), "ct");
}

TEST(LitFile, KeepsTablesAsJson) {
    MediumOptions options;
    options.classification = Classification{rampFunction(0, 1), "", "bone.json"};
    const VdbFile file = lit({"in.vdb", {test::namedBox("ct", 1)}, {}}, options);
    EXPECT_EQ(metaOf(*litRadiosity(file), "raysweep_transfer"), toJson(rampFunction(0, 1)));
}

TEST(LitFile, AnExtinctionOfTheUsersOwnIsNotMeant) {
    const VdbFile file{"in.vdb", {test::namedBox("extinction", 1)}, {}};
    EXPECT_FALSE(litExtinction(file));
    EXPECT_EQ(withoutLight(file).grids.size(), 1u);
}

TEST(LitFile, ClampsHalfFloatsAndSaysWhere) {
    const test::TemporaryFolder folder;
    const VdbFile input{"in.vdb", {test::namedBox("smoke", 1)}, {}};
    const FloatGrid::Ptr radiosity = test::namedBox("radiosity", 1);
    radiosity->tree().setValueOn(Coord(1, 1, 1), 1e6f);
    const auto clamped = writeLit(folder / "lit.vdb", input, sceneFrom(input), {"", "medium", 1, true}, {radiosity});
    ASSERT_EQ(clamped.size(), 1u);
    EXPECT_EQ(clamped[0].grid, "radiosity");
    EXPECT_EQ(clamped[0].voxels, 1u);
}

TEST(LitFile, AnExtinctionThatIsNoNumberIsRefused) {
    const FloatGrid::Ptr radiosity = test::namedBox("radiosity", 1);
    radiosity->insertMeta("raysweep_extinction", openvdb::StringMetadata("thick"));
    try {
        litExtinctionScale(*radiosity);
        FAIL() << "no error";
    } catch (const InvalidArgument& e) {
        EXPECT_EQ(e.remedy, Remedy::giveExtinction);
        EXPECT_STREQ(e.what(), "metadata 'raysweep_extinction' of grid 'radiosity' is of type string, not a number");
    }
}
