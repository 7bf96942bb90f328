// Media that shine: what is scattered of their own light, and what is seen of it.
#include "raysweep/illuminate/illuminate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/render/render.h"
#include "support/closed_forms.h"
#include "support/volumes.h"
#include "support/worst.h"

using namespace raysweep;
using namespace raysweep::test;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::math::Transform;

namespace {

IlluminateOptions sweepsOf(int sweeps) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = sweeps;
    return options;
}

/// Emission of a medium that is as hot everywhere as one that shows radiance 1: q = 4 pi sigma (1 - albedo).
void makeIsothermal(Scene& scene, float albedo) {
    scene.medium.albedo = grey(albedo);
    scene.medium.emission = scene.medium.density;
    scene.medium.emissionScale = 4 * kPi * (1 - double(albedo)) * scene.medium.extinctionScale;
}

/// Mean of the active voxels.
double meanOf(const openvdb::GridBase& radiosity, const FloatGrid& density) {
    return fromOne(radiosity, density).mean;
}

}  // namespace

// An endless medium, thin and thick: what is scattered is the part albedo of all that collides, so the source function
// q / (4 pi sigma (1 - albedo)) less what is emitted is albedo q / (4 pi sigma (1 - albedo)).
TEST(FirePhysics, AnEndlessMediumScattersTheClosedForm) {
    double worst = 0;
    for (const double depth : {1e-3, 0.1, 1.0, 10.0, 1e3})
        for (const float albedo : {0.1f, 0.5f, 0.9f}) {
            Scene scene;
            scene.medium.density = boxVolume(Index3(8));
            scene.medium.extinctionScale = depth;
            makeIsothermal(scene, albedo);
            IlluminateOptions options = sweepsOf(depth < 0.01 ? 500 : 256);
            options.periodic = {true, true, true};
            options.unshotShare = 1e-6;
            if (depth < 0.01 && albedo > 0.6f) continue;  // light goes round ever so often
            const Illumination lit = illuminate(scene, options);
            const double found = meanOf(*lit.radiosity, *scene.medium.density);
            std::printf("  depth %g albedo %.1f: %.5f of %.5f, balance %.1e\n", depth, double(albedo), found,
                        double(albedo), lit.power.error());
            raiseTo(worst, std::abs(found / double(albedo) - 1));
            // Rays that go round thousands of times lose some of their floats' digits.
            EXPECT_LE(lit.power.error(), depth < 0.01 ? 5e-5 : 3e-7);
        }
    EXPECT_LE(worst, 1e-4);
}

// Kirchhoff: under a sky of the same radiance 1 an isothermal medium is as bright everywhere, and cannot be seen. Smoke
// over six decades, thin and thick voxels side by side.
TEST(FirePhysics, AnIsothermalMediumUnderASkyAsBrightCannotBeSeen) {
    for (const float albedo : {0.0f, 0.5f, 0.95f}) {
        Scene scene;
        scene.medium.density = noiseBall(12, 1e-4, 10);
        makeIsothermal(scene, albedo);
        scene.sky.radiance = grey(1);
        const Illumination lit = illuminate(scene, sweepsOf(1024));
        if (albedo > 0) {
            const double scattered = meanOf(*lit.radiosity, *scene.medium.density) / double(albedo);
            std::printf("  albedo %.2f: radiosity %.5f of what it should be\n", double(albedo), scattered);
            EXPECT_NEAR(scattered, 1, 2e-3);
        }
        RenderOptions options;
        options.background = grey(1);
        Camera camera;
        camera.width = camera.height = 96;
        const RenderInput input{scene.medium.density, 1, lit.radiosity, lit.emission};
        const Image image = render(input, framed(camera, worldBounds(input)), options).image;
        double mean = 0, worst = 0;
        for (std::size_t i = 0; i < image.pixels.size(); i += 4) {
            mean += double(image.pixels[i]) / (96 * 96);
            raiseTo(worst, std::abs(double(image.pixels[i]) - 1));
        }
        std::printf("  picture: mean %.5f, worst pixel off by %.4f\n", mean, worst);
        EXPECT_NEAR(mean, 1, 5e-4);
        EXPECT_LE(worst, 0.03);  // found: 0.028, without scattering, of steps through voxels of optical depth 10
    }
}

// A slab that is as hot everywhere sends out what it would absorb: of radiance 1, pi (1 - R - T) through each face.
TEST(FirePhysics, ASlabSendsOutWhatItWouldAbsorb) {
    for (const SlabReference& slab : kDiffuseSlabs) {
        if (slab.albedo == 1) continue;
        Scene scene;
        scene.medium.density = boxVolume(Index3(8, 8, 32));
        scene.medium.extinctionScale = slab.opticalThickness / 32;
        makeIsothermal(scene, float(slab.albedo));
        IlluminateOptions options = sweepsOf(2048);
        options.periodic = {true, true, false};
        const Illumination lit = illuminate(scene, options);
        const double exact = kPi * (1 - slab.reflectance - slab.transmittance) * 2 * 64;
        std::printf("  thickness %.1f albedo %.1f: sends out %.4f of what it should\n", slab.opticalThickness,
                    slab.albedo, lit.power.escaped[0] / exact);
        EXPECT_NEAR(lit.power.escaped[0] / exact, 1,
                    2.5e-3);  // found: 2.3e-3, in voxels of depth 0.16; halved in half of them
        EXPECT_LE(lit.power.error(), 1e-6);
    }
}

namespace {

/// A ball of smoke, and fire beside it, on voxels of its own.
Scene fireBeside(const Transform::Ptr& transform, double& power) {
    Scene scene;
    scene.medium.density = ballVolume(24);
    scene.medium.extinctionScale = 0.1;
    const auto fire = FloatGrid::create();
    fire->setTransform(transform);
    // About a unit cube at (40, 12, 12).
    for (auto at = openvdb::CoordBBox(Coord(-40), Coord(40)).begin(); at; ++at) {
        const Vec3d p = fire->indexToWorld(*at) - Vec3d(40.2, 11.7, 12.1);
        if (std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}) <= 1.5) fire->tree().setValueOn(*at, 2.0f);
    }
    power = 2.0 * double(fire->activeVoxelCount()) * transform->voxelVolume();
    scene.medium.emission = fire;
    return scene;
}

}  // namespace

// A small fire far from the smoke lights it as a point of its power does, on whatever voxels it is.
TEST(FirePhysics, BesideTheSmokeItLightsItAsAPointOfItsPowerDoes) {
    for (int kind = 0; kind < 4; ++kind) {
        const auto transform = Transform::createLinearTransform(kind == 1 ? 0.3 : kind == 2 ? 1.5 : 1);
        if (kind == 3) transform->postRotate(0.5, openvdb::math::Z_AXIS);
        transform->postTranslate(Vec3d(40.2, 11.7, 12.1));
        double power = 0;
        Scene scene = fireBeside(transform, power);
        const Illumination lit = illuminate(scene, sweepsOf(4000));
        EXPECT_NEAR(lit.power.injected[0] / power, 1, 1e-5);
        EXPECT_NEAR(lit.emittedPower / power, 1, 1e-5);
        EXPECT_LE(lit.power.error(), 1e-5);
        ASSERT_TRUE(lit.emission);
        EXPECT_EQ(lit.emission->transform(), *transform);
        EXPECT_NEAR(massOf(*openvdb::gridPtrCast<FloatGrid>(lit.emission)) / power, 1, 1e-6) << "what is seen of it";
        scene.medium.emission = nullptr;
        scene.points.push_back({Vec3(40.2, 11.7, 12.1), grey(float(power))});
        const Illumination point = illuminate(scene, sweepsOf(512));
        const double ratio =
            meanOf(*lit.radiosity, *scene.medium.density) / meanOf(*point.radiosity, *scene.medium.density);
        std::printf("  transform %d: radiosity %.4f of that of a point\n", kind, ratio);
        EXPECT_NEAR(ratio, 1, 0.02);  // found: 0.009, the noise of few emitting voxels
    }
}

// The same fire on voxels of its own and on those of the smoke makes the same light.
TEST(FirePhysics, OnOtherVoxelsItMakesTheSameLight) {
    Scene scene;
    const FloatGrid::Ptr density = cloudVolume(32);
    scene.medium.density = density;
    scene.medium.extinctionScale = 0.3;
    const auto fire = boxVolume(Index3(12, 32, 12), 1);
    scene.medium.emission = fire;
    const Illumination own = illuminate(scene, sweepsOf(256));
    for (int kind = 0; kind < 3; ++kind) {
        // The same box: 24 x 64 x 24 voxels half as long, 4 x 8 x 3 long ones, or turned about its axis.
        const auto other = kind == 0 ? boxVolume(Index3(24, 64, 24), 1) : boxVolume(Index3(4, 8, 3), 1);
        const Vec3d scale = kind == 0 ? Vec3d(0.5) : Vec3d(3, 4, 4);
        openvdb::Mat4d matrix = openvdb::Mat4d::identity();
        matrix.setToScale(scale);
        matrix.postTranslate(scale * 0.5 - Vec3d(0.5));  // both boxes begin at -1/2
        other->setTransform(Transform::createLinearTransform(matrix));
        if (kind == 2) {
            other->transform().postTranslate(Vec3d(-5.5, 0, -5.5));
            other->transform().postRotate(kPi / 2, openvdb::math::Y_AXIS);
            other->transform().postTranslate(Vec3d(5.5, 0, 5.5));
        }
        scene.medium.emission = other;
        const Illumination lit = illuminate(scene, sweepsOf(256));
        const double difference = relativeDifference(*lit.radiosity, *own.radiosity, *density);
        std::printf("  %d: radiosity differs by %.2g\n", kind, difference);
        EXPECT_NEAR(lit.power.injected[0] / own.power.injected[0], 1, 1e-5);
        EXPECT_LE(difference, 1e-5);  // the same power in each voxel
    }
}

// What is emitted is no part of radiosity, so that it grows no more where smoke is thin; without scattering it is 0.
TEST(FirePhysics, RadiosityStaysSmoothWhereSmokeIsThin) {
    Scene scene;
    const FloatGrid::Ptr density = boxVolume(Index3(24), 1);
    density->tree().setValueOn(Coord(12), 1e-6f);
    scene.medium.density = density;
    scene.medium.extinctionScale = 0.05;
    scene.medium.emission = boxVolume(Index3(24), 1);
    scene.medium.albedo = grey(0);
    EXPECT_EQ(meanOf(*illuminate(scene).radiosity, *density), 0);
    scene.medium.albedo = grey(0.8f);
    const auto lit = openvdb::gridPtrCast<FloatGrid>(illuminate(scene, sweepsOf(512)).radiosity);
    const double ratio = double(lit->tree().getValue(Coord(12))) / double(lit->tree().getValue(Coord(12, 12, 14)));
    std::printf("  in the thin voxel %.3f times as much as near it\n", ratio);
    EXPECT_NEAR(ratio, 1, 0.1);  // found: 0.018, the noise of a voxel
}
