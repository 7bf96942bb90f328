#include "raysweep/illuminate/direct.h"

#include "raysweep/bricks/brick_grids.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/emission.h"
#include "raysweep/illuminate/quad.h"
#include "raysweep/illuminate/voxel_radiance.h"
#include "raysweep/sweep/diverging_front.h"
#include "raysweep/volume/statistics.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

void allocateSources(SolverState& state, const Scene& scene) {
    const bool emits = scene.medium.emission || !scene.quads.empty(),
               shines = !scene.suns.empty() || !scene.points.empty();
    if (!emits && !shines) return;
    for (int c = 0; c < state.medium.channels; ++c) {
        state.power.source[c] = BrickField(state.medium.volume.layout.brickCount());
        state.solid.seen[c] = BrickField(state.solid.surfaces.bricks.size());
        state.solid.emitted[c] = BrickField(state.solid.surfaces.bricks.size());
    }
}

/// Books a deposit of direct light, `deposit` times `power[c]`: part of it is absorbed, the rest becomes source.
void addCollided(SolverState& state, const BrickField& deposit, const ChannelPower& power) {
    const ChannelPower absorbed = orderedSum<ChannelPower>(state.medium.volume.layout.brickCount(), [&](std::size_t b) {
        ChannelPower sum;
        alignas(64) float g[kBrickVoxels];
        double share[kBrickVoxels];
        for (int c = 0; c < state.medium.channels; ++c) {
            effectiveAlbedos(state, c, b, g);
            absorbedShares(state, c, b, share);
            const float scale = float(power.value[c]);
            float* const source = state.power.source[c].brick(b);
            for (int i = 0; i < kBrickVoxels; ++i) {
                const float in = deposit.brick(b)[i] * scale;
                source[i] += g[i] * in;
                sum.value[c] += double(in) * share[i];
            }
        }
        return sum;
    });
    for (int c = 0; c < state.medium.channels; ++c) state.power.perInjection.absorbed[c] += absorbed.value[c];
}

/// What light of unit strength leaves in surface voxels, and what it would leave if nothing but a voxel's own surface
/// came before it. Their ratio is the visibility of the light, without the staircase that each of them has.
struct Visibility {
    const BrickField& deposit;
    const BrickField& furnace;  ///< of the surfaces' bricks
};

/// Light as it passes a voxel.
struct Crossing {
    Vec3 direction;  ///< of travel, world, unit
    double density;  ///< part of the light's power (of a sun: of its irradiance) per world area across it
};

/// Books what surfaces show of a light of `power` (a sun: irradiance) that passes a voxel as `at(voxel)`.
template <class LightAt>
void addSeen(SolverState& state, const Visibility& visibility, const Color& power, const LightAt& at) {
    const BrickLayout& layout = state.medium.volume.layout;
    parallelFor(layout.brickCount(), [&](std::size_t b) {
        const PackedNormal* const normals = state.solid.surfaces.normals(b);
        if (!normals) return;
        const std::uint32_t slot = state.solid.surfaces.slots[b];
        for (int i = 0; i < kBrickVoxels; ++i) {
            const float full = visibility.furnace.brick(slot)[i];
            if (!isSurface(normals[i]) || !(full > 0)) continue;
            const Crossing crossing = at(layout.origins[b] + Index3(i >> 6, (i >> 3) & 7, i & 7));
            const double cosine = std::max(0.0, -unpackNormal(normals[i]).dot(crossing.direction));
            const double visible = std::min(1.0, double(visibility.deposit.brick(b)[i]) / double(full));
            const double irradiance = crossing.density * cosine * visible / state.radianceUnit();
            for (int c = 0; c < state.medium.channels; ++c)
                state.solid.seen[c].brick(slot)[i] +=
                    float(double(state.medium.albedoView(c).brick(b)[i]) * irradiance * double(power[c]) / kPi);
        }
    });
}

/// In the paper's model all that is known of light on a surface is what was deposited.
bool showsDirectLight(const SolverState& state) {
    return state.solid.present && state.medium.model == ExchangeModel::corrected;
}

/// A sun's light comes down in one `linear` sweep that shoots nothing.
void addSun(SolverState& state, const Sun& sun) {
    BrickField deposit(state.medium.volume.layout.brickCount());
    const RayFront front =
        parallelFront(state.medium.volume.layout, sun.direction, 1, {}, state.medium.volume.periodic);
    Beam beam = darkBeam(state.medium, front);
    beam.entering[0] = 1;
    ExchangeFields fields;
    fields.tau = viewOf(state.medium.tau);
    fields.unshot[0] = {state.power.zero.brick(0), 0};
    fields.fresh[0] = viewOf(deposit);
    BrickField furnace;
    if (!state.solid.surfaces.empty()) fields.surfaces = &state.solid.surfaces;
    if (showsDirectLight(state)) fields.furnace = viewOf(furnace = BrickField(state.solid.surfaces.bricks.size()));
    beam.furnaceRay = 1;
    ExchangeConstants constants = exchangeConstants(state, 1, 1);
    constants.direct = true;
    const RaySums totals = sweep(state.medium.volume, {beam}, Interpolation::linear, fields, constants).front();

    ChannelPower power;
    for (int c = 0; c < state.medium.channels; ++c) {
        power.value[c] = double(sun.irradiance[c]) * front.crossSection / state.power.unit;
        state.power.perInjection.injected[c] += totals.entered[0] * power.value[c];
        state.power.perInjection.escaped[c] += totals.escaped[0] * power.value[c];
    }
    addCollided(state, deposit, power);
    if (showsDirectLight(state))
        addSeen(state, {deposit, furnace}, sun.irradiance, [&](const Index3&) { return Crossing{front.direction, 1}; });
}

/// A point's light goes out in diverging fronts.
void addPoint(SolverState& state, const PointLight& point, const openvdb::math::Transform& transform) {
    const openvdb::Vec3d inIndex = transform.worldToIndex({point.position.x, point.position.y, point.position.z});
    const Vec3 at(inIndex.x(), inIndex.y(), inIndex.z());
    const PointDeposit deposit =
        depositFromPoint({state.medium.volume, at, viewOf(state.medium.tau), 1 / state.medium.escape.meanStepLength(),
                          state.solid.surfaces.empty() ? nullptr : &state.solid.surfaces});
    ChannelPower power;
    for (int c = 0; c < state.medium.channels; ++c) {
        power.value[c] = double(point.power[c]) / state.power.unit;
        state.power.perInjection.injected[c] += power.value[c];
        state.power.perInjection.escaped[c] += deposit.escaped * power.value[c];
    }
    addCollided(state, deposit.power, power);
    if (!showsDirectLight(state)) return;
    const double nearest = 0.5 * state.medium.voxelEdge();  // a voxel is no closer to what is in it
    addSeen(state, {deposit.power, deposit.furnace}, point.power, [&](const Index3& voxel) {
        const Vec3 way = (Vec3(voxel) - at) * state.medium.volume.layout.worldFromIndex;
        const double distance = std::max(way.length(), nearest);
        return Crossing{way / distance, 1 / (4 * kPi * distance * distance)};
    });
}

/// Sums over voxels that emit.
struct EmissionBooks {
    double emitted = 0, left = 0, voxels = 0;
    EmissionBooks& operator+=(const EmissionBooks& o) {
        emitted += o.emitted, left += o.left, voxels += o.voxels;
        return *this;
    }
};

/// Makes `emitted`, power in each voxel, a source of channel `c`.
EmissionBooks addEmitted(SolverState& state, int c, const BrickField& emitted) {
    const EmissionBooks books = orderedSum<EmissionBooks>(state.medium.volume.layout.brickCount(), [&](std::size_t b) {
        EmissionBooks sum;
        const float* const tau = state.medium.tau.brick(b);
        const float* const albedo = state.medium.albedoView(c).brick(b);
        const PackedNormal* const normals = state.solid.surfaces.normals(b);
        for (int i = 0; i < kBrickVoxels; ++i) {
            const double power = double(emitted.brick(b)[i]);
            if (power == 0) continue;
            const bool surface = normals && isSurface(normals[i]);
            const EmittedShares shares =
                surface ? EmittedShares{1, 0} : emittedShares(state.medium, double(tau[i]), double(albedo[i]));
            const auto leaves = float(power * shares.leaving);
            state.power.source[c].brick(b)[i] += leaves;
            if (surface) state.solid.emitted[c].brick(state.solid.surfaces.slots[b])[i] += leaves;
            if (!state.power.scattered[c].empty())
                state.power.scattered[c].brick(b)[i] += float(power * shares.scattered);
            sum += {power, double(leaves), 1.0};
        }
        return sum;
    });
    state.power.perInjection.injected[c] += books.emitted;
    state.power.perInjection.absorbed[c] += books.emitted - books.left;
    return books;
}

Emitters addEmission(SolverState& state, double scale) {
    const BrickLayout& layout = state.medium.volume.layout;
    Emitters emitters;
    for (int c = 0; c < state.medium.channels; ++c) {
        state.power.scattered[c] = BrickField(layout.brickCount());
        std::copy_n(state.power.source[c].brick(0), layout.brickCount() * kBrickVoxels,
                    state.power.scattered[c].brick(0));
        const EmissionBooks books = addEmitted(
            state, c, gatherChannel(layout, *state.emission, c, scale * layout.voxelVolume / state.power.unit));
        emitters.voxels = std::max(emitters.voxels, std::size_t(books.voxels));
        emitters.power += books.emitted * state.power.unit;
    }
    return emitters;
}

/// @return voxels that emit
std::size_t addQuad(SolverState& state, const QuadLight& quad, const openvdb::FloatGrid& areas) {
    std::size_t voxels = 0;
    for (int c = 0; c < state.medium.channels; ++c) {
        const double perArea = kPi * double(quad.radiance[c]) / state.power.unit;
        const EmissionBooks books = addEmitted(state, c, gatherField(state.medium.volume.layout, areas, perArea));
        voxels = std::max(voxels, std::size_t(books.voxels));
    }
    return voxels;
}

/// Makes all that sources add show through D/F, as what is emitted does.
void takeSourcesAsEmitted(SolverState& state) {
    for (int c = 0; c < state.medium.channels && state.power.hasSource(); ++c)
        for (std::size_t b = 0; b < state.medium.volume.layout.brickCount(); ++b)
            if (state.solid.surfaces.normals(b))
                std::copy_n(state.power.source[c].brick(b), kBrickVoxels,
                            state.solid.emitted[c].brick(state.solid.surfaces.slots[b]));
}

/// Of all channels; 0 if none is above it.
double largestValue(const openvdb::GridBase& grid) {
    const std::vector<float> largest = valueRange(grid).max;  // empty: no active voxel
    return largest.empty() ? 0 : std::max(0.0, double(*std::max_element(largest.begin(), largest.end())));
}

/// About the largest power that any one voxel or ray will carry, W.
double choosePowerUnit(const Scene& scene, const SolverState& state) {
    const BrickLayout& layout = state.medium.volume.layout;
    const double area = std::pow(layout.voxelVolume, 2.0 / 3.0);
    double unit = 4 * kPi * area * double(maxComponent(scene.sky.radiance));
    for (const Sun& sun : scene.suns) unit = std::max(unit, area * double(maxComponent(sun.irradiance)));
    for (const QuadLight& quad : scene.quads) unit = std::max(unit, kPi * area * double(maxComponent(quad.radiance)));
    for (const PointLight& point : scene.points) unit = std::max(unit, double(maxComponent(point.power)));
    if (state.emission)
        unit = std::max(unit, largestValue(*state.emission) * scene.medium.emissionScale * layout.voxelVolume);
    return unit > 0 ? unit : 1;
}

}  // namespace

Emitters addDirectLight(SolverState& state, const Scene& scene) {
    state.power.unit = choosePowerUnit(scene, state);
    allocateSources(state, scene);
    const openvdb::math::Transform& transform = scene.medium.density->transform();
    for (const Sun& sun : scene.suns) addSun(state, sun);
    for (const PointLight& point : scene.points) addPoint(state, point, transform);
    Emitters emitters;
    if (state.emission) emitters = addEmission(state, scene.medium.emissionScale);
    for (std::size_t i = 0; i < scene.quads.size(); ++i)
        emitters.voxels += addQuad(state, scene.quads[i], *state.solid.quadAreas[i]);
    // What the paper's model shows of any light is what it deposits.
    if (!state.solid.surfaces.empty() && state.medium.model == ExchangeModel::asPrinted) takeSourcesAsEmitted(state);
    return emitters;
}

}  // namespace raysweep
