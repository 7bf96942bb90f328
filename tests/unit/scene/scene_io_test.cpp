// Files and options become a scene: what was chosen and assumed comes back with it, errors name the option at fault.
#include "raysweep/scene/scene_io.h"

#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"
#include "support/temporary_folder.h"
#include "support/volumes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

VdbFile fileOf(const openvdb::GridPtrVec& grids) {
    return {"some.vdb", grids, {}};
}

Classification rampOf(double low, double high, const std::string& text) {
    return {rampFunction(low, high), text, ""};
}

template <class Call>
InvalidArgument errorOf(const Call& call) {
    try {
        call();
    } catch (const InvalidArgument& e) {
        return e;
    }
    return InvalidArgument("no error");
}

}  // namespace

TEST(MediumFrom, WithoutOptionsIsAFogOfTheOnlyGrid) {
    const FloatGrid::Ptr smoke = test::namedBox("smoke", 0.5f);
    const MediumFromFile made = mediumFrom(fileOf({smoke}));
    EXPECT_EQ(made.medium.density, smoke);
    EXPECT_EQ(made.medium.extinctionScale, 1);
    EXPECT_EQ(made.medium.albedo, grey(0.9f));
    EXPECT_FALSE(made.medium.solid);
    EXPECT_EQ(made.origin.density, "smoke");
    EXPECT_FALSE(made.origin.ownExtinction);
    EXPECT_TRUE(made.origin.reasons.empty());
}

TEST(MediumFrom, SaysHowTheGridIsChosenAgain) {
    const FloatGrid::Ptr second = test::namedBox("density", 2);
    MediumOptions options;
    options.density = "density[1]";
    const MediumFromFile made = mediumFrom(fileOf({test::namedBox("density", 1), second}), options);
    EXPECT_EQ(made.medium.density, second);
    EXPECT_EQ(made.origin.density, "density[1]");
}

TEST(MediumFrom, DoesNotSeeWhatAnEarlierLightingAdded) {
    const FloatGrid::Ptr smoke = test::namedBox("smoke", 1);
    EXPECT_EQ(mediumFrom(fileOf({test::namedBox("radiosity", 1), smoke, test::namedBox("unshot", 1)})).medium.density,
              smoke);
}

TEST(MediumFrom, ClassifiesByARamp) {
    MediumOptions options;
    options.classification = rampOf(0, 1, "0,1");
    EXPECT_TRUE(options.isClassified());
    const MediumFromFile made = mediumFrom(fileOf({test::namedBox("ct", 1)}), options);
    EXPECT_TRUE(made.medium.solid);
    EXPECT_TRUE(made.origin.ownExtinction);
    EXPECT_NEAR(made.medium.density->tree().getValue(Coord(1, 1, 1)), extinctionFromOpacity(kRampOpacity, 1), 1e-5);
    EXPECT_EQ(made.origin.reasons.at(0), "extinction: 'ct' classified by the ramp 0,1");
}

// An import has the values 0 to 1 that its 8 bits stand for, whoever thinks of them as 0 to 255.
TEST(MediumFrom, SaysWhyNothingIsOpaque) {
    MediumOptions options;
    options.classification = rampOf(50, 200, "50,200");
    const MediumFromFile made = mediumFrom(fileOf({test::namedBox("ct", 1)}), options);
    EXPECT_EQ(made.origin.nothingOpaque,
              "'ct' has values from 1 to 1, to none of which the ramp 50,200 gives any opacity");
    options.classification = rampOf(0, 2, "0,2");
    EXPECT_EQ(mediumFrom(fileOf({test::namedBox("ct", 1)}), options).origin.nothingOpaque, "");
}

TEST(MediumFrom, TakesATablesColoursUnlessAnAlbedoIsGiven) {
    MediumOptions options;
    options.classification = Classification{{{{0, 0, grey(0.25f)}, {1, 0.5, grey(0.25f)}}, true}, "", "bone.json"};
    const MediumFromFile coloured = mediumFrom(fileOf({test::namedBox("ct", 1)}), options);
    ASSERT_TRUE(coloured.medium.albedoGrid);
    EXPECT_EQ(coloured.origin.reasons, (std::vector<std::string>{"extinction: 'ct' classified by the table 'bone.json'",
                                                                 "albedo: the table's colours"}));
    options.albedo = grey(0.5f);
    const MediumFromFile given = mediumFrom(fileOf({test::namedBox("ct", 1)}), options);
    EXPECT_FALSE(given.medium.albedoGrid);
    EXPECT_EQ(given.medium.albedo, grey(0.5f));
}

TEST(MediumFrom, ALevelSetIsASolidUnlessItsExtinctionIsGiven) {
    const FloatGrid::Ptr ball = FloatGrid::create(2);
    ball->setGridClass(openvdb::GRID_LEVEL_SET);
    ball->setName("ball");
    const Coord::ValueType reach = 6;
    for (const Coord& at : openvdb::CoordBBox(Coord(-reach), Coord(reach)))
        ball->tree().setValueOn(at, std::clamp(float(at.asVec3d().length()) - 4, -2.f, 2.f));
    MediumOptions options;
    options.levelSet = true;
    const MediumFromFile solid = mediumFrom(fileOf({ball}), options);
    EXPECT_TRUE(solid.medium.solid);
    ASSERT_TRUE(solid.origin.classification);
    EXPECT_EQ(solid.origin.classification->ramp, "0,1");
    options.extinction = 3;
    const MediumFromFile fog = mediumFrom(fileOf({ball}), options);
    EXPECT_FALSE(fog.medium.solid);
    EXPECT_FALSE(fog.origin.classification);
    EXPECT_TRUE(fog.origin.ownExtinction);
    EXPECT_EQ(fog.medium.extinctionScale, 3);
    EXPECT_EQ(errorOf([&] { mediumFrom(fileOf({ball})); }).remedy, Remedy::fillLevelSet);
}

TEST(MediumFrom, RepairsACopyAndSaysWhat) {
    const FloatGrid::Ptr smoke = test::namedBox("smoke", 1);
    smoke->tree().setValueOn(Coord(1, 2, 3), -1);
    smoke->tree().setValueOn(Coord(0, 0, 0), std::numeric_limits<float>::quiet_NaN());
    MediumOptions options;
    options.repair = true;
    const MediumFromFile made = mediumFrom(fileOf({smoke}), options);
    ASSERT_EQ(made.origin.repairs.size(), 1u);
    EXPECT_EQ(made.origin.repairs[0].grid, "smoke");
    EXPECT_EQ(made.origin.repairs[0].voxels, 2u);
    EXPECT_EQ(made.origin.repairs[0].kind, Repair::Kind::negative);
    EXPECT_EQ(made.medium.density->tree().getValue(Coord(1, 2, 3)), 0);
    EXPECT_EQ(smoke->tree().getValue(Coord(1, 2, 3)), -1);
    // A transfer function gives negative values a meaning.
    options.classification = rampOf(-3, 1, "-3,1");
    const MediumFromFile classified = mediumFrom(fileOf({smoke}), options);
    ASSERT_EQ(classified.origin.repairs.size(), 1u);
    EXPECT_EQ(classified.origin.repairs[0].voxels, 1u);
    EXPECT_EQ(classified.origin.repairs[0].kind, Repair::Kind::notFinite);
}

TEST(MediumFrom, MakesScatteringIsotropicBySimilarity) {
    MediumOptions options;
    options.extinction = 2;
    options.albedo = grey(0.5f);
    options.g = 0.5;
    const MediumFromFile made = mediumFrom(fileOf({test::namedBox("cloud", 1)}), options);
    EXPECT_DOUBLE_EQ(made.medium.extinctionScale, 1.5);  // times 1 - 0.5 * 0.5
    EXPECT_FLOAT_EQ(made.medium.albedo.x, 1 / 3.f);      // 0.5 (1 - 0.5) / (1 - 0.5 * 0.5)
    EXPECT_FALSE(made.origin.ownExtinction);
    EXPECT_EQ(made.origin.reasons.at(0),
              "phase function: mean cosine 0.5, by similarity as an isotropic medium of 0.75 times the extinction and "
              "albedo 0.3333");
}

TEST(MediumFrom, ErrorsNameTheOptionThatChose) {
    const VdbFile file = fileOf({test::namedBox("smoke", 1)});
    const auto subjectOf = [&](std::string MediumOptions::*field) {
        MediumOptions options;
        options.*field = "none";
        const InvalidArgument error = errorOf([&] { mediumFrom(file, options); });
        EXPECT_EQ(std::string(error.what()).rfind(error.subject + ": 'some.vdb': there is no grid called 'none'", 0),
                  0u)
            << error.what();
        return error.subject;
    };
    EXPECT_EQ(subjectOf(&MediumOptions::density), "density");
    EXPECT_EQ(subjectOf(&MediumOptions::albedoGrid), "albedo");
    EXPECT_EQ(subjectOf(&MediumOptions::emission), "emission");
    MediumOptions coloured;
    coloured.albedo = Color(0.1f, 0.2f, 0.3f);
    coloured.g = 0.5;
    EXPECT_EQ(errorOf([&] { mediumFrom(file, coloured); }).subject, "g");
}

TEST(MediumOptions, NameFieldValueAndBound) {
    const auto messageOf = [](const auto& change) {
        MediumOptions options;
        change(options);
        return std::string(errorOf([&] { options.validate(); }).what());
    };
    EXPECT_EQ(messageOf([](MediumOptions& o) { o.extinction = -1; }), "extinction -1: must be finite and not negative");
    EXPECT_EQ(messageOf([](MediumOptions& o) { o.albedo = grey(1.5f); }), "albedo 1.5: must be in [0, 1]");
    EXPECT_EQ(messageOf([](MediumOptions& o) { o.g = 1; }), "g 1: must be in (-1, 1)");
    EXPECT_EQ(messageOf([](MediumOptions& o) { o.g = std::nan(""); }), "g nan: must be in (-1, 1)");
    EXPECT_EQ(messageOf([](MediumOptions& o) { o.emissionScale = INFINITY; }),
              "emissionScale inf: must be finite and not negative");
}

TEST(SceneFrom, HoldsTheLightsAndAConstantSky) {
    SceneOptions options;
    options.suns = {Sun{}};
    options.points = {PointLight{}, PointLight{}};
    options.quads = {QuadLight{}};
    options.sky.radiance = grey(0.5f);
    const SceneFromFile made = sceneFrom(fileOf({test::namedBox("smoke", 1)}), options);
    EXPECT_EQ(made.scene.suns.size(), 1u);
    EXPECT_EQ(made.scene.points.size(), 2u);
    EXPECT_EQ(made.scene.quads.size(), 1u);
    EXPECT_EQ(made.scene.sky.radiance, grey(0.5f));
    EXPECT_FALSE(made.origin.skySuns);
    EXPECT_NO_THROW(made.scene.validate());
    options.sky.radiance = grey(-1);
    EXPECT_STREQ(errorOf([&] { options.validate(); }).what(), "sky radiance -1: must be finite and not negative");
}

TEST(SceneFrom, ASkyMapBecomesSunsAndARest) {
    const test::TemporaryFolder folder;
    Image map(64, 32, 3);
    std::fill(map.pixels.begin(), map.pixels.end(), 1.f);
    std::fill_n(map.at(20, 10), 3, 5000.f);
    SceneOptions options;
    options.sky.map = folder / "sky.exr";
    writeImage(options.sky.map, map);
    const SceneFromFile made = sceneFrom(fileOf({test::namedBox("smoke", 1)}), options);
    ASSERT_TRUE(made.origin.skySuns);
    EXPECT_EQ(made.origin.skySuns->count, 1);
    EXPECT_EQ(made.scene.suns.size(), 1u);
    EXPECT_TRUE(made.scene.sky.profile);
    EXPECT_EQ(made.origin.reasons.at(0).rfind("sky map: 1 sun(s) stand for its small bright parts, with ", 0), 0u);
    writeImage(options.sky.map, Image(5, 5, 3));
    const InvalidArgument error = errorOf([&] { sceneFrom(fileOf({test::namedBox("smoke", 1)}), options); });
    EXPECT_EQ(error.subject, "sky");
    EXPECT_EQ(std::string(error.what()).rfind("sky: '" + options.sky.map + "': a sky map must be a lat-long", 0), 0u);
}

TEST(Scene, SaysWhichLightHasNoMeaning) {
    Scene scene;
    EXPECT_STREQ(errorOf([&] { scene.validate(); }).what(), "the scene has no density grid");
    scene.medium.density = test::namedBox("smoke", 1);
    EXPECT_NO_THROW(scene.validate());
    scene.points = {PointLight{Vec3(0), grey(-2)}};
    EXPECT_STREQ(errorOf([&] { scene.validate(); }).what(),
                 "a point light's power -2: must be finite and not negative");
    scene.points.clear();
    scene.medium.extinctionScale = -1;
    EXPECT_STREQ(errorOf([&] { scene.validate(); }).what(), "extinction -1: must be in [0, 1e30]");
}
