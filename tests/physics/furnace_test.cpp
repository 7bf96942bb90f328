// The white furnace: nothing absorbs and light of radiance 1 comes from everywhere, so it is 1 everywhere.
#include "raysweep/illuminate/illuminate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace raysweep;

namespace {

/// A ball of voxels of random density, spread evenly over decades from `low` to `high`.
openvdb::FloatGrid::Ptr noiseBall(int radius, double low, double high) {
    auto grid = openvdb::FloatGrid::create();
    auto accessor = grid->getAccessor();
    std::mt19937_64 random(7);
    for (int i = -radius; i <= radius; ++i)
        for (int j = -radius; j <= radius; ++j)
            for (int k = -radius; k <= radius; ++k)
                if (i * i + j * j + k * k <= radius * radius)
                    accessor.setValue({i, j, k}, float(low * std::pow(high / low, uniform01(random))));
    return grid;
}

struct Departure {
    double mean = 0, rms = 0;
};

Departure fromOne(const openvdb::FloatGrid& radiosity, const openvdb::FloatGrid& density) {
    double sum = 0, squares = 0;
    std::size_t count = 0;
    const auto accessor = radiosity.getConstAccessor();
    for (auto on = density.cbeginValueOn(); on; ++on) {
        const double value = double(accessor.getValue(on.getCoord()));
        sum += value;
        squares += (value - 1) * (value - 1);
        ++count;
    }
    return {sum / double(count), std::sqrt(squares / double(count))};
}

}  // namespace

TEST(Furnace, RandomVoxelsDisappear) {
    Scene scene;
    const auto density = noiseBall(16, 1e-6, 10);
    scene.medium.density = density;
    scene.medium.albedo = grey(1);
    scene.sky.radiance = grey(1);
    IlluminateOptions options;
    options.tolerance = 0;
    Departure before{0, 1};
    for (const int sweeps : {64, 1024}) {
        options.sweeps = sweeps;
        const Illumination lit = illuminate(scene, options);
        const Departure now = fromOne(*openvdb::gridPtrCast<openvdb::FloatGrid>(lit.radiosity), *density);
        std::printf("%d sweeps + %d: mean %.6f rms %.6f balance %.2e\n", sweeps, lit.finishingSweeps, now.mean, now.rms,
                    lit.power.error());
        EXPECT_LT(now.rms, before.rms);
        EXPECT_LT(lit.power.error(), 1e-5);
        before = now;
    }
    EXPECT_LT(std::abs(before.mean - 1), 5e-4);
    EXPECT_LT(before.rms, 5e-3);
}
