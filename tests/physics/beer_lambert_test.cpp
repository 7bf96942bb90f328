// Without scattering a sun's light falls off exponentially along its way (Beer and Lambert), whatever its direction.
#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/illuminate/illuminate.h"
#include "support/volumes.h"
#include "support/worst.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

// The sum of steps is exact; what remains is that deposits are floats.
constexpr double kTolerance = 1e-4;

}  // namespace

TEST(BeerLambert, HoldsAlongTheSixAxes) {
    // The box fills its bricks, and every ray along an axis passes the same number of voxels.
    const auto density = boxVolume({16, 24, 32});
    for (int axis = 0; axis < 3; ++axis)
        for (const int sign : {1, -1})
            for (const double extinction : {1e-4, 0.01, 0.1, 1.0}) {
                Scene scene;
                scene.medium.density = density;
                scene.medium.extinctionScale = extinction;
                scene.medium.albedo = grey(0);
                Vec3 direction(0);
                direction[axis] = sign;
                scene.suns.push_back({direction, grey(1)});
                const Illumination lit = illuminate(scene);
                const Index3 size(16, 24, 32);
                // A bilinear footprint reaches one voxel beyond the box, where rays along an axis meet nothing.
                const double area = double(size.x) * size.y * size.z / size[axis];
                const double exact = area * -std::expm1(-extinction * size[axis]);
                EXPECT_LE(std::abs(lit.power.absorbed[0] / exact - 1), kTolerance)
                    << "axis " << axis << " sign " << sign << " extinction " << extinction;
            }
}

// Wide enough for many rays to come in at different heights of a voxel: a bilinear footprint that fades in over a voxel
// is exact in the mean over these heights only.
TEST(BeerLambert, HoldsObliquelyThroughASlab) {
    double worst = 0;
    for (int axis = 0; axis < 3; ++axis) {
        Index3 size(64);
        size[axis] = 32;
        const auto density = boxVolume(size);
        for (const double cosine : {0.95, -0.7, 0.4, -0.1})
            for (const double thickness : {0.01, 1.0, 4.0}) {
                Scene scene;
                scene.medium.density = density;
                scene.medium.extinctionScale = thickness / 32;
                scene.medium.albedo = grey(0);
                const double sine = std::sqrt(1 - cosine * cosine);
                Vec3 direction;
                direction[axis] = cosine;
                direction[(axis + 1) % 3] = sine * std::cos(0.7);
                direction[(axis + 2) % 3] = sine * std::sin(0.7);
                scene.suns.push_back({direction, grey(1)});
                IlluminateOptions options;
                options.periodic = {axis != 0, axis != 1, axis != 2};
                const Illumination lit = illuminate(scene, options);
                const double exact = -std::expm1(-thickness / std::abs(cosine));
                const double measured = lit.power.absorbed[0] / lit.power.injected[0];
                raiseTo(worst, std::abs(measured / exact - 1));
                EXPECT_LE(std::abs(measured / exact - 1), kTolerance)
                    << "axis " << axis << " cosine " << cosine << " thickness " << thickness << ": " << measured
                    << " instead of " << exact;
                EXPECT_LE(lit.power.error(), 1e-5);
            }
    }
    std::printf("  worst %.1e\n", worst);
}

TEST(BeerLambert, HoldsInEveryLayer) {
    constexpr int kLayers = 32;
    const double depth = 0.125;  // of a layer
    const auto density = boxVolume({8, 8, kLayers});
    for (const double cosine : {1.0, 0.8}) {
        Scene scene;
        scene.medium.density = density;
        scene.medium.extinctionScale = depth;
        scene.medium.albedo = grey(1);
        scene.suns.push_back({Vec3(std::sqrt(1 - cosine * cosine), 0, cosine), grey(1)});
        IlluminateOptions options;
        options.periodic = {true, true, false};
        options.sweeps = 0;  // light that has been scattered once: all that was collided, as nothing absorbs
        const Illumination lit = illuminate(scene, options);
        const auto& unshot = static_cast<const openvdb::FloatGrid&>(*lit.unshot);
        for (int layer = 0; layer < kLayers; ++layer) {
            double sum = 0;
            for (int i = 0; i < 64; ++i) sum += double(unshot.tree().getValue({i / 8, i % 8, layer}));
            const double from = std::exp(-layer * depth / cosine), to = std::exp(-(layer + 1) * depth / cosine);
            const double exact = 64 * cosine * (from - to);
            EXPECT_LE(std::abs(sum / exact - 1), kTolerance) << "layer " << layer << " cosine " << cosine;
        }
    }
}
