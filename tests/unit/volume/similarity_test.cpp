#include "raysweep/volume/similarity.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/volumes.h"

using namespace raysweep;
using namespace raysweep::test;
using openvdb::Coord;
using openvdb::FloatGrid;

namespace {

Medium uniformMedium(float albedo) {
    Medium medium;
    medium.density = boxVolume({4, 4, 4}, 3);
    medium.extinctionScale = 0.5;
    medium.albedo = grey(albedo);
    return medium;
}

const FloatGrid& floats(const openvdb::GridBase::ConstPtr& grid) {
    return dynamic_cast<const FloatGrid&>(*grid);
}

double extinctionAt(const Medium& medium, const Coord& at) {
    return double(medium.density->tree().getValue(at)) * medium.extinctionScale;
}

}  // namespace

TEST(Similarity, KeepsAbsorptionAndScalesScattering) {
    for (const double g : {-0.9, -0.3, 0.5, 0.85, 0.999})
        for (const float albedo : {0.0f, 0.3f, 0.9f, 0.999f, 1.0f}) {
            const Medium medium = uniformMedium(albedo), similar = similarIsotropicMedium(medium, g);
            const double before = extinctionAt(medium, {1, 2, 3}), after = extinctionAt(similar, {1, 2, 3});
            EXPECT_NEAR(after * (1 - double(similar.albedo.x)), before * (1 - double(albedo)), 2e-7 * before);
            EXPECT_NEAR(after * double(similar.albedo.x), before * double(albedo) * (1 - g), 2e-7 * before);
            EXPECT_TRUE(isGrey(similar.albedo));
            EXPECT_EQ(similar.density, medium.density) << "the density serves as it is";
        }
    EXPECT_EQ(similarIsotropicMedium(uniformMedium(1), 0.7).albedo, grey(1)) << "what absorbs nothing stays so";
}

TEST(Similarity, IsNothingForIsotropicScattering) {
    Medium medium = uniformMedium(0.9f);
    medium.albedo = Color(0.9f, 0.5f, 0.1f);
    const Medium similar = similarIsotropicMedium(medium, 0);
    EXPECT_EQ(similar.extinctionScale, medium.extinctionScale);
    EXPECT_EQ(similar.albedo, medium.albedo);
    EXPECT_EQ(similar.density, medium.density);
}

TEST(Similarity, AnAlbedoGridIsScaledVoxelByVoxel) {
    Medium medium = uniformMedium(0.1f);
    const auto albedo = boxVolume({4, 4, 4}, 0.8f);
    albedo->tree().setValue({1, 1, 1}, 0.25f);
    albedo->tree().setValueOff({2, 2, 2}, 0.8f);  // not active: nothing is scattered there
    medium.albedoGrid = albedo;
    const Medium similar = similarIsotropicMedium(medium, 0.5);
    EXPECT_EQ(similar.extinctionScale, 1);
    EXPECT_EQ(similar.density->getName(), "extinction");
    EXPECT_EQ(similar.density->activeVoxelCount(), 64u);
    EXPECT_EQ(similar.density->transform(), medium.density->transform());
    const struct {
        Coord at;
        double albedo;
    } voxels[] = {{{0, 3, 0}, 0.8}, {{1, 1, 1}, 0.25}, {{2, 2, 2}, 0}};
    for (const auto& v : voxels) {
        EXPECT_NEAR(extinctionAt(similar, v.at), 1.5 * (1 - 0.5 * v.albedo), 1e-6) << v.at;
        float value = 0;
        const bool on = floats(similar.albedoGrid).tree().probeValue(v.at, value);
        EXPECT_EQ(on, v.albedo > 0);
        if (!on) continue;
        EXPECT_NEAR(double(value), 0.5 * v.albedo / (1 - 0.5 * v.albedo), 1e-6) << v.at;
    }
}

TEST(Similarity, TilesOfDensityAreDividedWhereAlbedoIsNotUniform) {
    auto density = FloatGrid::create();
    density->tree().addTile(2, Coord(0), 2.0f, true);  // 128^3
    auto albedo = FloatGrid::create();
    albedo->tree().addTile(2, Coord(0), 0.5f, true);
    albedo->tree().setValueOn({5, 6, 7}, 1.0f);
    albedo->tree().setValueOn({-5, 6, 7}, 1.0f);  // where there is no density
    Medium medium;
    medium.density = density;
    medium.albedoGrid = albedo;
    const Medium similar = similarIsotropicMedium(medium, 0.5);
    EXPECT_EQ(similar.density->activeVoxelCount(), 128u * 128 * 128);
    EXPECT_EQ(similar.density->tree().leafCount(), 1u);
    EXPECT_EQ(similar.density->tree().getValue({5, 6, 7}), 1.0f);
    EXPECT_EQ(similar.density->tree().getValue({5, 6, 8}), 1.5f);
    EXPECT_EQ(similar.density->tree().getValue({100, 6, 8}), 1.5f);
    EXPECT_EQ(similar.density->tree().getValue({-5, 6, 7}), 0.0f);
}

TEST(Similarity, RefusesWhatHasNoSimilarMedium) {
    for (const double g : {1.0, -1.0, 2.0, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THROW(similarIsotropicMedium(uniformMedium(0.9f), g), InvalidArgument) << g;
    Medium medium = uniformMedium(0.9f);
    medium.albedo = Color(0.9f, 0.8f, 0.7f);
    EXPECT_THROW(similarIsotropicMedium(medium, 0.5), InvalidArgument);
    medium = uniformMedium(0.9f);
    medium.albedoGrid = openvdb::Vec3SGrid::create();
    EXPECT_THROW(similarIsotropicMedium(medium, 0.5), InvalidArgument);
    medium.albedoGrid = boxVolume({4, 4, 4}, 1.5f);
    EXPECT_THROW(similarIsotropicMedium(medium, 0.5), InvalidArgument);
}

// On voxels of its own an albedo is that of the density's that it lies in.
TEST(Similarity, TakesAlbedoOnOtherVoxels) {
    Medium medium = uniformMedium(0.9f);
    const auto finer = boxVolume({64, 64, 64}, 0.5f);
    finer->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    medium.albedoGrid = finer;
    const Medium similar = similarIsotropicMedium(medium, 0.5);
    EXPECT_EQ(similar.albedoGrid->transform(), medium.density->transform());
    EXPECT_NEAR(similar.density->tree().getValue(openvdb::Coord(1)),
                medium.extinctionScale * medium.density->tree().getValue(openvdb::Coord(1)) * 0.75, 1e-6);
}
