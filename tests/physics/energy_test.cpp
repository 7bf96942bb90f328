// Power is never lost and never made: injected = absorbed + escaped + unshot, whatever the light and the method.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "raysweep/illuminate/illuminate.h"
#include "support/volumes.h"
#include "support/worst.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

enum class Light { sun, pointInside, pointOutside, sky, emission, all };
constexpr Light kLights[] = {Light::sun, Light::pointInside, Light::pointOutside,
                             Light::sky, Light::emission,    Light::all};

openvdb::GridBase::Ptr emissionOf(const openvdb::FloatGrid& density, bool coloured) {
    auto grey = density.deepCopy();
    auto colours = openvdb::Vec3SGrid::create();
    auto accessor = colours->getAccessor();
    for (auto on = grey->beginValueOn(); on; ++on) {
        on.setValue(on.getCoord().x() % 3 == 0 ? 0.7f : 0.0f);
        accessor.setValue(on.getCoord(), openvdb::Vec3s(*on, 2 * *on, 0.1f * *on));
    }
    // Some of it where there is no extinction.
    grey->tree().setValue({20, 3, 3}, 5);
    accessor.setValue({20, 3, 3}, openvdb::Vec3s(5, 1, 3));
    if (coloured) return colours;
    return grey;
}

Scene litScene(Light light, bool coloured) {
    static const auto density = noiseBall(9, 1e-3, 10);
    const Color tint = coloured ? Color(1, 0.3f, 2) : grey(1);
    Scene scene;
    scene.medium.density = density;
    scene.medium.albedo = coloured ? Color(0.99f, 0.5f, 1) : grey(0.9f);
    const bool all = light == Light::all;
    if (all || light == Light::sun) scene.suns.push_back({Vec3(0.3, -1, 0.2), tint * 3});
    if (all || light == Light::pointInside) scene.points.push_back({Vec3(1.3, -2.1, 0.4), tint * 50});
    if (all || light == Light::pointOutside) scene.points.push_back({Vec3(-20, 4, 7), tint * 500});
    if (all || light == Light::sky) scene.sky.radiance = tint;
    if (all || light == Light::emission) scene.medium.emission = emissionOf(*density, coloured);
    return scene;
}

void expectNoNegative(const openvdb::GridBase& grid) {
    const auto check = [](float value) { return value >= 0 && std::isfinite(value); };
    std::size_t bad = 0;
    if (grid.isType<openvdb::FloatGrid>()) {
        for (auto v = static_cast<const openvdb::FloatGrid&>(grid).cbeginValueAll(); v; ++v) bad += !check(*v);
    } else {
        for (auto v = dynamic_cast<const openvdb::Vec3SGrid&>(grid).cbeginValueAll(); v; ++v)
            for (int c = 0; c < 3; ++c) bad += !check((*v)[c]);
    }
    EXPECT_EQ(bad, 0u) << "negative or not finite values in " << grid.getName();
}

}  // namespace

// Fields are floats; sums over voxels and sweeps are doubles. Users are promised 1e-5; limits are 10 % above what is
// found: 2.34e-8 at most of all that follow, 4.9e-10 at most after any number of sweeps, 2.14e-9 without scattering.
TEST(Energy, IsConservedForEveryLightAndMethod) {
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = 30;
    double worst = 0;
    for (const Light light : kLights)
        for (const bool coloured : {false, true}) {
            const Scene scene = litScene(light, coloured);
            for (const Exchange exchange : {Exchange::medium, Exchange::paper})
                for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear})
                    for (const Remaining remaining : {Remaining::shoot, Remaining::drop, Remaining::spread}) {
                        options.exchange = exchange;
                        options.interpolation = interpolation;
                        options.remaining = remaining;
                        const Illumination lit = illuminate(scene, options);
                        const double error = lit.power.error();
                        raiseTo(worst, error);
                        EXPECT_LE(error, 2.57e-8)
                            << "light " << int(light) << " coloured " << coloured << " exchange " << int(exchange)
                            << " interpolation " << int(interpolation) << " remaining " << int(remaining);
                        EXPECT_GT(lit.power.injected[0], 0);
                        expectNoNegative(*lit.radiosity);
                        expectNoNegative(*lit.unshot);
                    }
        }
    std::printf("  worst balance error %.1e\n", worst);
}

TEST(Energy, IsConservedAtEveryStage) {
    for (const int sweeps : {0, 1, 2, 19, 20, 21, 100}) {
        IlluminateOptions options;
        options.tolerance = 0;
        options.sweeps = sweeps;
        options.remaining = Remaining::drop;
        EXPECT_LE(illuminate(litScene(Light::all, false), options).power.error(), 5.3e-10) << sweeps << " sweeps";
    }
}

TEST(Energy, IsConservedWithoutScattering) {
    for (const Light light : kLights) {
        Scene scene = litScene(light, false);
        scene.medium.albedo = grey(0);
        const Illumination lit = illuminate(scene);
        EXPECT_LE(lit.power.error(), 2.34e-9) << "light " << int(light);
        EXPECT_EQ(lit.sweeps, 0);
    }
}

TEST(Energy, OfPointLightsIsTheirPower) {
    for (const Light light : {Light::pointInside, Light::pointOutside}) {
        const Scene scene = litScene(light, false);
        const double power = double(scene.points.front().power.x);
        // Nothing but the sums' rounding.
        EXPECT_LE(std::abs(illuminate(scene).power.injected[0] / power - 1), 1e-6);
    }
}

TEST(Energy, OfEmissionIsItsSum) {
    const Scene scene = litScene(Light::emission, false);
    double sum = 0;
    const auto& emission = static_cast<const openvdb::FloatGrid&>(*scene.medium.emission);
    for (auto on = emission.cbeginValueOn(); on; ++on) sum += double(*on);
    const Illumination lit = illuminate(scene);
    EXPECT_LE(std::abs(lit.power.injected[0] / sum - 1), 1e-6);  // float voxels
    EXPECT_LE(std::abs(lit.emittedPower / sum - 1), 1e-6);
    const auto seen = openvdb::gridPtrCast<openvdb::FloatGrid>(lit.emission);
    EXPECT_LE(std::abs(massOf(*seen) / sum - 1), 1e-12) << "what is seen of it";
    for (auto on = emission.cbeginValueOn(); on; ++on) ASSERT_EQ(seen->tree().getValue(on.getCoord()), *on);
}

namespace {

constexpr int kEdge = 64;

Scene boxScene() {
    Scene scene;
    scene.medium.density = boxVolume({kEdge, kEdge / 2, kEdge / 4});
    scene.medium.extinctionScale = 0.01;
    return scene;
}

}  // namespace

// A front is a lattice of one ray per voxel, and what counts as injected is what the rays carry that meet the bricks'
// bounding box in the middle of a slice, give or take the voxel that a bilinear footprint reaches beyond it: the closed
// form holds to about two voxels of each edge.
TEST(Energy, OfTheSunIsIrradianceTimesProjectedArea) {
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0.3, -1, 0.2), Vec3(1, 2, -3)}) {
        Scene scene = boxScene();
        scene.suns.push_back({direction, grey(3)});
        const Vec3 d = direction.normalized();
        const double n = kEdge;
        const double area =
            std::abs(d.x) * (n / 2) * (n / 4) + std::abs(d.y) * n * (n / 4) + std::abs(d.z) * n * (n / 2);
        const double ratio = illuminate(scene).power.injected[0] / (3 * area);
        std::printf("  sun along (%g, %g, %g): injected / closed form = %.5f\n", direction.x, direction.y, direction.z,
                    ratio);
        EXPECT_LE(std::abs(ratio - 1), 2.0 / (n / 2) + 2.0 / (n / 4));
    }
}

TEST(Energy, OfTheSkyIsRadianceTimesPiTimesSurface) {
    Scene scene = boxScene();
    scene.sky.radiance = grey(1);
    IlluminateOptions options;
    options.tolerance = 0;
    options.sweeps = 1024;
    const double n = kEdge, surface = 2 * (n * (n / 2) + n * (n / 4) + (n / 2) * (n / 4));
    const double ratio = illuminate(scene, options).power.injected[0] / (kPi * surface);
    std::printf("  sky: injected / closed form = %.5f\n", ratio);
    EXPECT_LE(std::abs(ratio - 1), 2.0 / (n / 4));
}

namespace {

/// A medium, its light, and the name of the case.
struct MediumCase {
    std::string name;
    Scene scene;
};

openvdb::FloatGrid::Ptr randomBlock(int edge, double low, double high) {
    auto grid = openvdb::FloatGrid::create();
    auto accessor = grid->getAccessor();
    std::mt19937_64 random(7);
    for (int i = 0; i < edge; ++i)
        for (int j = 0; j < edge; ++j)
            for (int k = 0; k < edge; ++k)
                accessor.setValue({i, j, k}, float(low * std::pow(high / low, uniform01(random))));
    return grid;
}

/// As unlike as media get: thick and thin, even and rugged, nearly conservative and nearly black, grey, coloured and of
/// an albedo that varies, voxels that are no cubes, all kinds of light.
std::vector<MediumCase> mediumCases() {
    std::vector<MediumCase> cases;
    const auto add = [&](const std::string& name, const openvdb::FloatGrid::Ptr& density,
                         const Color& albedo) -> Scene& {
        Scene scene;
        scene.medium.density = density;
        scene.medium.albedo = albedo;
        cases.push_back({name, scene});
        return cases.back().scene;
    };
    const Sun sun{Vec3(0.3, -1, 0.2), grey(3)};
    add("random voxels 1e-4 to 3, sun", randomBlock(32, 1e-4, 3), grey(0.9f)).suns.push_back(sun);
    add("ball of voxels 1e-3 to 10, coloured, sky", noiseBall(9, 1e-3, 10), Color(0.99f, 0.5f, 0.8f)).sky.radiance =
        grey(1);
    add("even block, 0.5 a voxel, point inside", boxVolume({24, 24, 24}, 0.5f), grey(0.5f))
        .points.push_back({Vec3(11.3, 12.1, 9.4), grey(50)});
    add("thick block, 4 a voxel, nearly conservative, sun", boxVolume({24, 16, 32}, 4), grey(0.999f))
        .suns.push_back(sun);
    add("cloud, nearly black, point outside", cloudVolume(32), grey(0.05f))
        .points.push_back({Vec3(-20, 4, 7), grey(500)});

    Scene& varying = add("cloud, albedo from a grid, sun and sky", cloudVolume(40), grey(1));
    const auto albedo = varying.medium.density->deepCopy();
    for (auto on = albedo->beginValueOn(); on; ++on) on.setValue(on.getCoord().x() % 2 == 0 ? 0.99f : 0.3f);
    varying.medium.albedoGrid = albedo;
    varying.suns.push_back(sun);
    varying.sky.radiance = grey(0.5f);

    const auto flat = cloudVolume(40)->deepCopy();
    openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
    matrix.setToScale(openvdb::Vec3d(0.1, 0.1, 0.25));
    flat->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    Scene& stretched = add("voxels of 0.1 x 0.1 x 0.25, sun and sky", flat, grey(0.95f));
    stretched.medium.extinctionScale = 5;
    stretched.suns.push_back(sun);
    stretched.sky.radiance = grey(1);
    return cases;
}

double valueAt(const openvdb::GridBase& grid, const openvdb::Coord& at, int channel) {
    if (grid.isType<openvdb::FloatGrid>())
        return double(static_cast<const openvdb::FloatGrid&>(grid).tree().getValue(at));
    return double(static_cast<const openvdb::Vec3SGrid&>(grid).tree().getValue(at)[channel]);
}

/// What the answer says is absorbed: 4 pi s V S (1 - albedo) / albedo, summed over voxels that scatter.
double absorbedByAnswer(const Medium& medium, const openvdb::GridBase& radiosity, int channel) {
    const openvdb::math::Mat4d matrix = medium.density->transform().baseMap()->getAffineMap()->getMat4();
    const double volume = std::abs(matrix.getMat3().det());
    double sum = 0;
    for (auto on = medium.density->cbeginValueOn(); on; ++on) {
        const double albedo =
            medium.albedoGrid ? valueAt(*medium.albedoGrid, on.getCoord(), channel) : double(medium.albedo[channel]);
        const double extinction = double(*on) * medium.extinctionScale;
        sum += 4 * kPi * extinction * volume * valueAt(radiosity, on.getCoord(), channel) * (1 - albedo) / albedo;
    }
    return sum;
}

/// The worst difference between what the answer absorbs and what is said of it, as part of the power injected.
double worstOfAnswer(const Medium& medium, const Illumination& lit) {
    double worst = lit.power.error();
    for (int c = 0; c < lit.plan.channels; ++c) {
        const double absorbed = absorbedByAnswer(medium, *lit.radiosity, c), injected = lit.power.injected[c];
        raiseTo(worst, std::abs(absorbed - lit.power.absorbed[c]) / injected);
        raiseTo(worst, std::abs(injected - lit.power.escaped[c] - lit.power.unshot[c] - absorbed) / injected);
    }
    return worst;
}

}  // namespace

// Asked: 1e-4 from a coarse start, 1e-5 from the dark. Found: the rounding of floats, 2.5e-7 at most, in the thick
// block, where power is scattered most often.
constexpr double kRounding = 2.75e-7;

// Whatever the way to it: what the fields that users get absorb is what is reported, and closes the balance.
TEST(Energy, TheAnswerAbsorbsWhatIsBooked) {
    for (const MediumCase& c : mediumCases())
        for (const bool dark : {false, true}) {
            IlluminateOptions options;
            options.tolerance = 0;
            options.darkStart = dark;
            double worst = 0;
            for (const int sweeps : {4, 24, 64}) {
                options.sweeps = sweeps;
                raiseTo(worst, worstOfAnswer(c.scene.medium, illuminate(c.scene, options)));
            }
            std::printf("  %-55s %s start: %.1e\n", c.name.c_str(), dark ? "dark  " : "coarse", worst);
            EXPECT_LE(worst, kRounding) << c.name;
        }
}

TEST(Energy, TheAnswerAbsorbsWhatIsBookedByEveryMethod) {
    const MediumCase c = mediumCases().front();
    for (const Interpolation interpolation : {Interpolation::nearest, Interpolation::linear})
        for (const Remaining remaining : {Remaining::shoot, Remaining::drop, Remaining::spread})
            for (const int beams : {1, 3, 8}) {
                IlluminateOptions options;
                options.tolerance = 0;
                options.sweeps = 24;
                options.interpolation = interpolation;
                options.remaining = remaining;
                options.beams = beams;
                EXPECT_LE(worstOfAnswer(c.scene.medium, illuminate(c.scene, options)), kRounding)
                    << "interpolation " << int(interpolation) << ", remaining " << int(remaining) << ", " << beams
                    << " beams";
            }
}
