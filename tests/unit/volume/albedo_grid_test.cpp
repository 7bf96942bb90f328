#include "raysweep/volume/albedo_grid.h"

#include "support/volumes.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace raysweep;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;
using openvdb::math::Transform;

namespace {

Medium mediumOf(const FloatGrid::Ptr& density, const openvdb::GridBase::Ptr& albedo) {
    Medium medium;
    medium.density = density;
    medium.albedoGrid = albedo;
    return medium;
}

}  // namespace

// Also at its edges: what is inactive there has no say.
TEST(AlbedoOnDensity, OfOneColourIsThatColourWhereverItReaches) {
    const FloatGrid::Ptr density = test::boxVolume(Index3(24));
    for (const double edge : {0.31, 0.5, 2.0, 3.0, 8.0}) {
        const auto albedo = Vec3SGrid::create();
        const auto transform = Transform::createLinearTransform(edge);
        transform->postTranslate(Vec3d(0.5 * edge - 0.5));  // both begin at the same corner
        albedo->setTransform(transform);
        const int count = int(std::ceil(24 / edge - 1e-9));
        albedo->denseFill({Coord(0), Coord(count - 1)}, Vec3s(0.9f, 0.5f, 0.1f));
        const auto result = openvdb::gridConstPtrCast<Vec3SGrid>(albedoOnDensity(mediumOf(density, albedo)));
        EXPECT_EQ(result->transform(), density->transform());
        for (auto on = density->cbeginValueOn(); on; ++on)
            for (int c = 0; c < 3; ++c)  // sums of weights are rounded
                ASSERT_NEAR(result->tree().getValue(on.getCoord())[c], Vec3s(0.9f, 0.5f, 0.1f)[c], 1e-6)
                    << edge << " at " << on.getCoord();
    }
}

// A mean over the voxel: a chequerboard of finer voxels is grey.
TEST(AlbedoOnDensity, OfFinerVoxelsIsTheirMean) {
    const auto albedo = FloatGrid::create();
    const auto transform = Transform::createLinearTransform(0.25);
    transform->postTranslate(Vec3d(-0.375));
    albedo->setTransform(transform);
    auto accessor = albedo->getAccessor();
    for (int i = 0; i < 32 * 32 * 32; ++i) {
        const Coord at(i / 1024, i / 32 % 32, i % 32);
        accessor.setValueOn(at, (at.x() + at.y() + at.z()) % 2 ? 0.8f : 0.2f);
    }
    const FloatGrid::Ptr density = test::boxVolume(Index3(8));
    const auto result = openvdb::gridConstPtrCast<FloatGrid>(albedoOnDensity(mediumOf(density, albedo)));
    for (auto on = result->cbeginValueOn(); on; ++on) ASSERT_NEAR(*on, 0.5, 1e-6) << on.getCoord();
}

// Linear interpolation gives linear functions back, on turned voxels, too.
TEST(AlbedoOnDensity, OfALinearFunctionIsThatFunction) {
    const auto f = [](const Vec3d& p) { return float(0.5 + 0.01 * p.x() - 0.02 * p.y() + 0.005 * p.z()); };
    const FloatGrid::Ptr albedo = test::boxVolume(Index3(20));
    for (auto on = albedo->beginValueOn(); on; ++on) on.setValue(f(albedo->indexToWorld(on.getCoord())));
    const FloatGrid::Ptr density = test::boxVolume(Index3(6));
    const auto transform = Transform::createLinearTransform(0.7);
    transform->postRotate(0.4, openvdb::math::X_AXIS);
    transform->postTranslate(Vec3d(6, 8, 7));
    density->setTransform(transform);
    const auto result = openvdb::gridConstPtrCast<FloatGrid>(albedoOnDensity(mediumOf(density, albedo)));
    for (auto on = result->cbeginValueOn(); on; ++on)
        ASSERT_NEAR(*on, f(density->indexToWorld(on.getCoord())), 1e-6) << on.getCoord();
}

TEST(AlbedoOnDensity, IsTheGridItselfWhereItFitsAnd0OutsideOfIt) {
    const FloatGrid::Ptr density = test::boxVolume(Index3(8)), albedo = test::boxVolume(Index3(2), 0.5f);
    EXPECT_EQ(albedoOnDensity(mediumOf(density, albedo)), albedo);
    albedo->setTransform(Transform::createLinearTransform(0.5));
    const auto result = openvdb::gridConstPtrCast<FloatGrid>(albedoOnDensity(mediumOf(density, albedo)));
    EXPECT_FLOAT_EQ(result->tree().getValue(Coord(0)), 0.5f);
    EXPECT_EQ(result->tree().getValue(Coord(5, 5, 5)), 0);
}

TEST(AlbedoOnDensity, RefusesWhatIsNoAlbedo) {
    const FloatGrid::Ptr density = test::boxVolume(Index3(8)), albedo = test::boxVolume(Index3(2), 1.5f);
    albedo->setTransform(Transform::createLinearTransform(0.5));
    EXPECT_THROW(albedoOnDensity(mediumOf(density, albedo)), InvalidArgument);
}
