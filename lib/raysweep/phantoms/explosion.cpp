#include "raysweep/phantoms/explosion.h"

#include "raysweep/core/types.h"
#include "raysweep/phantoms/leaf_fill.h"
#include "raysweep/phantoms/noise.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/voxels_of.h"

#include <openvdb/tools/Activate.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

constexpr double kReach = 0.86;  ///< half the cube's edge, in the unit of the lengths that follow
constexpr int kBalls = 14;
constexpr double kBump = 0.2;                       ///< height of the largest bumps
constexpr double kBumpSize = 0.3;                   ///< their width
constexpr double kEdge = 0.05;                      ///< depth below the surface at which the smoke is dense
constexpr double kFlame = 0.07;                     ///< height above the surface to which flames reach
constexpr double kThinnest = 0.004;                 ///< lower densities are left out
constexpr double kCoolest = 1100, kHottest = 2900;  ///< K; what is cooler does not shine

struct Ball {
    Vec3 centre;
    double radius;
};

/// Evenly around the middle, of random sizes, more above than below.
std::vector<Ball> makeBalls(std::uint32_t seed) {
    const auto random = [&](int i, int j) { return latticeRandom(i, j, 0, seed ^ 0xf1e3u); };
    std::vector<Ball> balls{{Vec3(0), 0.4}};
    for (int i = 1; i < kBalls; ++i) {
        const double up = 1 - 2 * (i - 0.5) / (kBalls - 1), turn = kPi * (3 - std::sqrt(5.0)) * i;
        const double level = std::sqrt(1 - up * up), away = 0.32 + 0.12 * random(i, 1) + 0.06 * up;
        balls.push_back({Vec3(level * std::cos(turn), level * std::sin(turn), up) * away, 0.17 + 0.14 * random(i, 2)});
    }
    return balls;
}

/// How far `p` is outside of the balls, without bumps.
double outside(const std::vector<Ball>& balls, const Vec3& p) {
    double distance = 1e3;
    for (const Ball& ball : balls) distance = std::min(distance, (p - ball.centre).length() - ball.radius);
    return distance;
}

double smoothStep(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// At a point.
struct State {
    double depth;  ///< below the bumpy surface
    double heat;   ///< in [0,1]
};

State stateAt(const std::vector<Ball>& balls, const Vec3& p, std::uint32_t seed) {
    const Vec3 q = p * (1 / kBumpSize);
    const Vec3 warp(gradientNoise(q * 0.7, seed + 101), gradientNoise(q * 0.7, seed + 202),
                    gradientNoise(q * 0.7, seed + 303));
    const double bumps = billowNoise(q + warp * 0.4, 6, 0.5, seed);
    const double depth = kBump * (2.2 * bumps - 0.5) - outside(balls, p);
    // Valleys between bumps are hot, and so is the middle.
    const double flicker = fractalNoise(q * 0.8 + warp * 0.6, 5, 0.55, seed + 77);
    const double heat = 0.5 + 1.3 * flicker - 1.5 * (bumps - 0.25) + 0.5 * depth;
    return {depth, std::clamp(heat, 0.0, 1.0) * smoothStep((depth + kFlame) / (2 * kFlame))};
}

double smokeOf(const State& state) {
    const double density = smoothStep(state.depth / kEdge) * (1 - 0.97 * smoothStep(state.heat / 0.6));
    return density < kThinnest ? 0 : density;
}

/// Black body relative to the hottest in red, by Wien's law.
openvdb::Vec3s colourOf(double heat) {
    constexpr double kWavelengths[3] = {610e-9, 550e-9, 465e-9}, kSecondConstant = 1.4388e-2;  // m, m K
    const auto spectral = [&](double wavelength, double temperature) {
        return std::pow(wavelength, -5) * std::exp(-kSecondConstant / (wavelength * temperature));
    };
    const double temperature = kCoolest + (kHottest - kCoolest) * heat;
    openvdb::Vec3s colour;
    for (int c = 0; c < 3; ++c)
        colour[c] =
            float(kBrightestFire * spectral(kWavelengths[c], temperature) / spectral(kWavelengths[0], kHottest));
    return colour;
}

openvdb::math::Transform::Ptr transformOf(const PhantomOptions& options) {
    const double h = options.voxelSize > 0 ? options.voxelSize : 2.0 / options.size;
    const auto transform = openvdb::math::Transform::createLinearTransform(h);
    transform->postTranslate(openvdb::Vec3d(options.size - 1) * (-0.5 * h));
    return transform;
}

/// What `value` makes of each voxel; where that is 0 there is none.
template <class GridType, class Both, class Value>
typename GridType::Ptr partOf(const Both& both, const Value& value) {
    const auto grid = withVoxelsOf<GridType>(both);
    setActive(*grid, [&] {
        return [&, in = both.getConstUnsafeAccessor()](const openvdb::Coord& at) { return value(in.getValue(at)); };
    });
    openvdb::tools::deactivate(grid->tree(), openvdb::zeroVal<typename GridType::ValueType>());
    openvdb::tools::pruneInactive(grid->tree());
    return grid;
}

}  // namespace

Explosion makeExplosion(const PhantomOptions& options) {
    options.validate();
    const std::vector<Ball> balls = makeBalls(options.seed);
    const double scale = 2 * kReach / options.size;
    const FillRegion region{openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(options.size - 1)),
                            Vec3(options.size - 1) * 0.5};
    const auto near = [&](const Vec3& centre, int&) {
        return outside(balls, centre * scale) <= 1.7 * kBump + kFlame + kLeafRadius * scale;
    };
    // Smoke and heat of a voxel come from the same noise.
    using BothGrid = openvdb::Grid<openvdb::tree::Tree4<openvdb::Vec2s, 5, 4, 3>::Type>;
    BothGrid both;
    both.setTransform(transformOf(options));
    fillLeaves<int>(
        both, region, near,
        [&](const Vec3& p, int) {
            const State state = stateAt(balls, p * scale, options.seed);
            return openvdb::Vec2s(float(options.density * smokeOf(state)), float(state.heat));
        },
        sizeof(openvdb::Vec2s) + sizeof(float) + sizeof(openvdb::Vec3s));
    Explosion explosion;
    explosion.density = partOf<openvdb::FloatGrid>(both, [](const openvdb::Vec2s& v) { return v[0]; });
    explosion.density->setName("density");
    explosion.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    explosion.fire = partOf<openvdb::Vec3SGrid>(
        both, [](const openvdb::Vec2s& v) { return v[1] > 0 ? colourOf(double(v[1])) : openvdb::Vec3s(0); });
    explosion.fire->setName("fire");
    explosion.fire->setGridClass(openvdb::GRID_FOG_VOLUME);
    return explosion;
}

}  // namespace raysweep
