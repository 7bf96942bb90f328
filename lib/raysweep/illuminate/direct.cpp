#include "raysweep/illuminate/direct.h"

#include "raysweep/core/parallel.h"
#include "raysweep/sweep/diverging_front.h"
#include "raysweep/volume/brick_grids.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

void allocateSource(SolverState& state) {
    for (int c = 0; c < state.channels; ++c) state.source[c] = BrickField(state.volume.layout.brickCount());
}

/// Books a deposit of direct light, `deposit` times `power[c]`: part of it is absorbed, the rest becomes source.
void addCollided(SolverState& state, const BrickField& deposit, const ChannelPower& power) {
    const ChannelPower absorbed = orderedSum<ChannelPower>(state.volume.layout.brickCount(), [&](std::size_t b) {
        ChannelPower sum;
        alignas(64) float g[kBrickVoxels];
        for (int c = 0; c < state.channels; ++c) {
            effectiveAlbedos(state, c, b, g);
            const float scale = float(power.value[c]);
            float* const source = state.source[c].brick(b);
            for (int i = 0; i < kBrickVoxels; ++i) {
                const float in = deposit.brick(b)[i] * scale;
                source[i] += g[i] * in;
                sum.value[c] += double(in) * (1 - double(g[i]));
            }
        }
        return sum;
    });
    for (int c = 0; c < state.channels; ++c) state.perInjection.absorbed[c] += absorbed.value[c];
}

/// A sun's light comes down in one `linear` sweep that shoots nothing.
void addSun(SolverState& state, const Sun& sun) {
    BrickField deposit(state.volume.layout.brickCount());
    const RayFront front = parallelFront(state.volume.layout, sun.direction, 1, 0, 0, state.volume.periodic);
    ExchangeStep step = exchangeStep(state, front, 1);
    step.entering[0] = 1;
    ExchangeFields fields;
    fields.tau = viewOf(state.tau);
    fields.unshot[0] = {state.zero.brick(0), 0};
    fields.fresh[0] = viewOf(deposit);
    const SweepTotals totals = sweep(state.volume, front, Interpolation::linear, fields, step);

    ChannelPower power;
    for (int c = 0; c < state.channels; ++c) {
        power.value[c] = double(sun.irradiance[c]) * front.crossSection / state.powerUnit;
        state.perInjection.injected[c] += totals.entered[0] * power.value[c];
        state.perInjection.escaped[c] += totals.escaped[0] * power.value[c];
    }
    addCollided(state, deposit, power);
}

/// A point's light goes out in diverging fronts.
void addPoint(SolverState& state, const PointLight& point, const openvdb::math::Transform& transform) {
    const openvdb::Vec3d at = transform.worldToIndex({point.position.x, point.position.y, point.position.z});
    BrickField deposit(state.volume.layout.brickCount());
    const double escaped = depositFromPoint(state.volume, {at.x(), at.y(), at.z()}, viewOf(state.tau),
                                            1 / state.escape.meanStepLength(), deposit);
    ChannelPower power;
    for (int c = 0; c < state.channels; ++c) {
        power.value[c] = double(point.power[c]) / state.powerUnit;
        state.perInjection.injected[c] += power.value[c];
        state.perInjection.escaped[c] += escaped * power.value[c];
    }
    addCollided(state, deposit, power);
}

/// Power emitted in a voxel: of each unit the part p / (1 - albedo (1 - p)) leaves it, after any scatterings inside.
double emittedThatLeaves(const SolverState& state, double tau, double albedo) {
    if (state.exchange == MediumExchange::paper) return 1;
    const double p = state.escape.fit().probability(tau);
    return p / (1 - albedo * (1 - p));
}

/// @return voxels that emit but have no extinction
std::size_t addEmission(SolverState& state, const Medium& medium) {
    const BrickLayout& layout = state.volume.layout;
    std::size_t invisible = 0;
    for (int c = 0; c < state.channels; ++c) {
        const BrickField emitted =
            gatherChannel(layout, *medium.emission, c, medium.emissionScale * layout.voxelVolume / state.powerUnit);
        struct Books {
            double emitted = 0, left = 0, invisible = 0;
            Books& operator+=(const Books& o) {
                emitted += o.emitted, left += o.left, invisible += o.invisible;
                return *this;
            }
        };
        const Books books = orderedSum<Books>(layout.brickCount(), [&](std::size_t b) {
            Books sum;
            const float* const tau = state.tau.brick(b);
            const float* const albedo = state.albedoView(c).brick(b);
            for (int i = 0; i < kBrickVoxels; ++i) {
                const double power = double(emitted.brick(b)[i]);
                if (power == 0) continue;
                const auto leaves = float(power * emittedThatLeaves(state, double(tau[i]), double(albedo[i])));
                state.source[c].brick(b)[i] += leaves;
                sum += {power, double(leaves), tau[i] > 0 ? 0.0 : 1.0};
            }
            return sum;
        });
        state.perInjection.injected[c] += books.emitted;
        state.perInjection.absorbed[c] += books.emitted - books.left;
        invisible = std::max(invisible, std::size_t(books.invisible));
    }
    return invisible;
}

double largestValue(const openvdb::GridBase& grid) {
    float largest = 0;
    if (grid.isType<openvdb::FloatGrid>())
        for (auto on = static_cast<const openvdb::FloatGrid&>(grid).cbeginValueOn(); on; ++on)
            largest = std::max(largest, *on);
    else
        for (auto on = static_cast<const openvdb::Vec3SGrid&>(grid).cbeginValueOn(); on; ++on)
            largest = std::max({largest, (*on)[0], (*on)[1], (*on)[2]});
    return double(largest);
}

/// About the largest power that any one voxel or ray will carry, W.
double choosePowerUnit(const Scene& scene, const BrickLayout& layout) {
    const double area = std::pow(layout.voxelVolume, 2.0 / 3.0);
    double unit = 4 * kPi * area * double(maxComponent(scene.sky.radiance));
    for (const Sun& sun : scene.suns) unit = std::max(unit, area * double(maxComponent(sun.irradiance)));
    for (const PointLight& point : scene.points) unit = std::max(unit, double(maxComponent(point.power)));
    if (scene.medium.emission)
        unit = std::max(unit, largestValue(*scene.medium.emission) * scene.medium.emissionScale * layout.voxelVolume);
    return unit > 0 ? unit : 1;
}

}  // namespace

std::size_t addDirectLight(SolverState& state, const Scene& scene) {
    state.powerUnit = choosePowerUnit(scene, state.volume.layout);
    if (!scene.suns.empty() || !scene.points.empty() || scene.medium.emission) allocateSource(state);
    for (const Sun& sun : scene.suns) addSun(state, sun);
    for (const PointLight& point : scene.points) addPoint(state, point, scene.medium.density->transform());
    return scene.medium.emission ? addEmission(state, scene.medium) : 0;
}

}  // namespace raysweep
