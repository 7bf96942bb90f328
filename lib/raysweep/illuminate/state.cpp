#include "raysweep/illuminate/state.h"

#include "raysweep/bricks/brick_grids.h"
#include "raysweep/bricks/brick_map.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/emission.h"
#include "raysweep/illuminate/quad.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/albedo_grid.h"
#include "raysweep/volume/voxel_check.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

/// Fields of a coarse level for each wavelength: those of a solution, and three to compare it with.
constexpr std::size_t kCoarseFields = 8;

BrickField uniformBrick(float value) {
    BrickField field(1);
    std::fill_n(field.brick(0), kBrickVoxels, value);
    return field;
}

/// Makes the voxels that a quad passes a surface that looks where the quad does.
void addQuadNormals(SolverState& state, const QuadLight& quad, const openvdb::FloatGrid& areas) {
    const PackedNormal normal = packNormal(quad.u.cross(quad.v).normalized());
    forEachActive(areas, [&](float, const openvdb::CoordBBox& box) {
        const Index3 voxel(box.min().x(), box.min().y(), box.min().z());
        addSurfaceBrick(state.solid.surfaces, state.medium.volume.layout.brickCount(),
                        state.medium.volume.map.find(voxel))[offsetInBrick(voxel)] = normal;
    });
}

/// Bytes per voxel of a brick at the peak: tau and the fields of each wavelength.
std::size_t bytesPerVoxel(const Scene& scene, const IlluminateOptions& options, const Plan& plan) {
    const std::size_t perChannel = 4 + (scene.medium.albedoGrid ? 1 : 0) + (scene.medium.emission ? 1 : 0) +
                                   (options.interpolation == Interpolation::linear ? 1 : 0) +
                                   (options.snapshotEvery > 0 ? 1 : 0);
    const std::size_t ofWhite = options.interpolation == Interpolation::linear ? 3 : 2;  // white_furnace.h
    const std::size_t ofSurfaces = plan.surfaces ? 2 + 2 * std::size_t(plan.channels) + ofWhite : 0;
    // A coarse level has a seventh of the voxels, with all that are coarser still; more where bricks are partly full.
    const bool coarse = plan.sweeps && !plan.surfaces && mayStartCoarse(options);
    const std::size_t ofCoarse = coarse ? (1 + std::size_t(plan.channels) * kCoarseFields) / 4 : 0;
    return 4 * (1 + std::size_t(plan.channels) * perChannel + ofSurfaces + ofCoarse);
}

}  // namespace

bool mayStartCoarse(const IlluminateOptions& options) {
    return !options.darkStart && options.remaining == Remaining::shoot && !isPeriodic(options.periodic) &&
           options.exchange != Exchange::paper;
}

SolverState prepareState(const Scene& scene, const IlluminateOptions& options, const Plan& plan) {
    const Medium& medium = scene.medium;
    checkVoxels(*medium.density, "density");
    const openvdb::GridBase::ConstPtr emission = emissionOnVoxels(medium);
    std::vector<openvdb::GridBase::ConstPtr> grids{medium.density};
    if (emission) grids.push_back(emission);
    std::vector<openvdb::FloatGrid::Ptr> quadAreas;
    for (const QuadLight& quad : scene.quads) {
        quadAreas.push_back(rasterizeQuad(quad, medium.density->transform()));
        grids.push_back(quadAreas.back());
    }
    BrickLayout layout = layoutBricks(grids, bytesPerVoxel(scene, options, plan));
    Escape escape(layout.worldFromIndex);
    SolverState state(std::move(layout), options.periodic, std::move(escape));
    state.emission = emission;
    state.medium.model = options.exchange == Exchange::paper ? ExchangeModel::asPrinted : ExchangeModel::corrected;
    state.solid.present = plan.surfaces;
    state.medium.channels = plan.channels;

    const BrickLayout& bricks = state.medium.volume.layout;
    state.medium.tau =
        gatherField(bricks, *medium.density, medium.extinctionScale * state.medium.escape.meanStepLength());
    parallelFor(
        bricks.brickCount(),
        [&](std::size_t b) {
            float* const tau = state.medium.tau.brick(b);
            for (int i = 0; i < kBrickVoxels; ++i) tau[i] = tau[i] < kThinnest ? 0.0f : std::min(tau[i], kThickest);
        },
        16);

    if (plan.surfaces)
        state.solid.surfaces = findSurfaces(
            bricks, state.medium.volume.map, state.medium.tau, options.periodic,
            {std::cbrt(bricks.voxelVolume) / state.medium.escape.meanStepLength(), options.surfaceThreshold});
    state.solid.quadAreas = std::move(quadAreas);
    for (std::size_t i = 0; i < scene.quads.size(); ++i)
        addQuadNormals(state, scene.quads[i], *state.solid.quadAreas[i]);
    state.power.zero = uniformBrick(0);
    state.medium.uniformAlbedo = !medium.albedoGrid;
    const openvdb::GridBase::ConstPtr albedo = medium.albedoGrid ? albedoOnDensity(medium) : nullptr;
    for (int c = 0; c < state.medium.channels; ++c)
        state.medium.albedo[c] = albedo ? gatherChannel(bricks, *albedo, c, 1) : uniformBrick(medium.albedo[c]);
    return state;
}

void allocateSweepFields(SolverState& state, const IlluminateOptions& options) {
    const std::size_t bricks = state.medium.volume.layout.brickCount();
    for (int c = 0; c < state.medium.channels; ++c) {
        state.power.unshot[c] = BrickField(bricks);
        state.power.recent[c] = BrickField(bricks);
        state.power.total[c] = BrickField(bricks);
        if (options.interpolation == Interpolation::linear) state.power.fresh[c] = BrickField(bricks);
    }
    if (state.solid.present) state.solid.furnace = BrickField(state.solid.surfaces.bricks.size());
}

ExchangeFields exchangeFields(SolverState& state, bool injecting) {
    ExchangeFields fields;
    fields.channels = state.medium.channels;
    fields.tau = viewOf(state.medium.tau);
    for (int c = 0; c < state.medium.channels; ++c) {
        fields.albedo[c] = state.medium.albedoView(c);
        const bool source = injecting && state.power.hasSource();
        fields.source[c] =
            source ? BrickView<const float>(viewOf(state.power.source[c])) : sharedView(state.power.zero);
        fields.unshot[c] = viewOf(state.power.unshot[c]);
        fields.deposit[c] = viewOf(state.power.recent[c]);
        fields.fresh[c] = viewOf(state.power.fresh[c]);
    }
    if (!state.solid.surfaces.empty()) fields.surfaces = &state.solid.surfaces;
    if (injecting && !state.solid.furnace.empty()) fields.furnace = viewOf(state.solid.furnace);
    return fields;
}

void effectiveAlbedos(const SolverState& state, int channel, std::size_t b, float* g) {
    effectiveAlbedos({state.medium.model, state.medium.escape.fit()}, state.solid.surfaces.normals(b),
                     state.medium.tau.brick(b), state.medium.albedoView(channel).brick(b), g);
}

double sumOf(const BrickField& field) {
    return orderedSum(
        field.brickCount(),
        [&](std::size_t b) {
            double sum = 0;
            for (int i = 0; i < kBrickVoxels; ++i) sum += double(field.brick(b)[i]);
            return sum;
        },
        16);
}

ExchangeConstants exchangeConstants(const SolverState& state, double zeta, int beams) {
    ExchangeConstants constants;
    constants.model = state.medium.model;
    constants.escape = state.medium.escape.fit();
    constants.zeta = float(zeta);
    // A hair less than its share where shares are rounded, so that together they never take more than there is.
    constexpr float kRounding = 1e-6f;
    constants.mostShot = (beams & (beams - 1)) == 0 ? 1.0f / float(beams) : (1 - kRounding) / float(beams);
    return constants;
}

Beam darkBeam(const MediumFields& medium, const RayFront& front) {
    Beam beam;
    beam.front = front;
    const double length = medium.model == ExchangeModel::asPrinted ? medium.voxelEdge() : front.stepLength;
    beam.stepScale = float(length / medium.escape.meanStepLength());
    beam.furnaceRay = float(front.crossSection / medium.voxelFace());
    return beam;
}

double thickShare(const SolverState& state) {
    const double limit = 2 * state.medium.escape.meanStepLength() / state.medium.voxelEdge();
    const double thick = orderedSum(state.medium.volume.layout.brickCount(), [&](std::size_t b) {
        const PackedNormal* const normals = state.solid.surfaces.normals(b);
        int count = 0;
        for (int i = 0; i < kBrickVoxels; ++i)
            count += double(state.medium.tau.brick(b)[i]) > limit && !(normals && isSurface(normals[i]));
        return double(count);
    });
    return thick / std::max<double>(1, double(state.medium.volume.layout.activeVoxels));
}

}  // namespace raysweep
