#include "raysweep/illuminate/state.h"

#include "raysweep/bricks/brick_grids.h"
#include "raysweep/bricks/brick_map.h"
#include "raysweep/core/error.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/quad.h"
#include "raysweep/volume/grid_transform.h"
#include "raysweep/volume/voxel_check.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

// A voxel this thick is a wall; more would only overflow.
constexpr float kThickest = 1e9f;

/// Fields of a coarse level for each wavelength: those of a solution, and three to compare it with.
constexpr std::size_t kCoarseFields = 8;

BrickField uniformBrick(float value) {
    BrickField field(1);
    std::fill_n(field.brick(0), kBrickVoxels, value);
    return field;
}

void checkEmission(const openvdb::GridBase& grid) {
    if (grid.isType<openvdb::FloatGrid>())
        checkVoxels(static_cast<const openvdb::FloatGrid&>(grid), "emission");
    else if (grid.isType<openvdb::Vec3SGrid>())
        checkVoxels(static_cast<const openvdb::Vec3SGrid&>(grid), "emission");
    else
        throw InvalidArgument("emission grid '" + grid.getName() + "' is of type " + grid.type() +
                              "; give a float or vec3s grid");
}

/// Makes the voxels that a quad passes a surface that looks where the quad does.
void addQuadNormals(SolverState& state, const QuadLight& quad, const openvdb::FloatGrid& areas) {
    const PackedNormal normal = packNormal(quad.u.cross(quad.v).normalized());
    for (auto area = areas.cbeginValueOn(); area; ++area) {
        const Index3 voxel(area.getCoord().x(), area.getCoord().y(), area.getCoord().z());
        addSurfaceBrick(state.surfaces, state.volume.layout.brickCount(),
                        state.volume.map.find(voxel))[offsetInBrick(voxel)] = normal;
    }
}

/// Bytes per voxel of a brick at the peak: tau and the fields of each wavelength.
std::size_t bytesPerVoxel(const Scene& scene, const IlluminateOptions& options, const Plan& plan) {
    const std::size_t perChannel = 4 + (scene.medium.albedoGrid ? 1 : 0) +
                                   (options.interpolation == Interpolation::linear ? 1 : 0) +
                                   (options.snapshotEvery > 0 ? 1 : 0);
    const std::size_t ofSurfaces = plan.surfaces ? 2 + 2 * std::size_t(plan.channels) : 0;
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
    if (medium.emission) checkEmission(*medium.emission);
    std::vector<openvdb::GridBase::ConstPtr> grids{medium.density};
    if (medium.emission) grids.push_back(medium.emission);
    std::vector<openvdb::FloatGrid::Ptr> quadAreas;
    for (const QuadLight& quad : scene.quads) {
        quadAreas.push_back(rasterizeQuad(quad, medium.density->transform()));
        grids.push_back(quadAreas.back());
    }
    BrickLayout layout = layoutBricks(grids, bytesPerVoxel(scene, options, plan));
    Escape escape(layout.worldFromIndex);
    SolverState state(std::move(layout), options.periodic, std::move(escape));
    state.exchange = options.exchange == Exchange::paper ? ExchangeModel::paper : ExchangeModel::consistent;
    state.surfaceThreshold = options.surfaceThreshold;
    state.solids = plan.surfaces;
    state.channels = plan.channels;

    const BrickLayout& bricks = state.volume.layout;
    state.tau = gatherField(bricks, *medium.density, medium.extinctionScale * state.escape.meanStepLength());
    parallelFor(
        bricks.brickCount(),
        [&](std::size_t b) {
            float* const tau = state.tau.brick(b);
            for (int i = 0; i < kBrickVoxels; ++i) tau[i] = tau[i] < kThinnest ? 0.0f : std::min(tau[i], kThickest);
        },
        16);

    if (plan.surfaces)
        state.surfaces =
            findSurfaces(bricks, state.volume.map, state.tau, options.periodic,
                         std::cbrt(bricks.voxelVolume) / state.escape.meanStepLength(), options.surfaceThreshold);
    state.quadAreas = std::move(quadAreas);
    for (std::size_t i = 0; i < scene.quads.size(); ++i) addQuadNormals(state, scene.quads[i], *state.quadAreas[i]);
    state.zero = uniformBrick(0);
    state.uniformAlbedo = !medium.albedoGrid;
    if (medium.albedoGrid) {
        checkAlbedo(*medium.albedoGrid);
        requireSameTransform(*medium.albedoGrid, *medium.density);
    }
    for (int c = 0; c < state.channels; ++c)
        state.albedo[c] =
            medium.albedoGrid ? gatherChannel(bricks, *medium.albedoGrid, c, 1) : uniformBrick(medium.albedo[c]);
    return state;
}

void allocateSweepFields(SolverState& state, const IlluminateOptions& options) {
    const std::size_t bricks = state.volume.layout.brickCount();
    for (int c = 0; c < state.channels; ++c) {
        state.unshot[c] = BrickField(bricks);
        state.recent[c] = BrickField(bricks);
        state.total[c] = BrickField(bricks);
        if (options.interpolation == Interpolation::linear) state.fresh[c] = BrickField(bricks);
    }
    if (state.solids) state.furnace = BrickField(state.surfaces.bricks.size());
}

ExchangeFields exchangeFields(SolverState& state, bool injecting) {
    ExchangeFields fields;
    fields.channels = state.channels;
    fields.tau = viewOf(state.tau);
    for (int c = 0; c < state.channels; ++c) {
        fields.albedo[c] = state.albedoView(c);
        const bool source = injecting && state.hasSource();
        fields.source[c] = source ? BrickView<const float>(viewOf(state.source[c])) : sharedView(state.zero);
        fields.unshot[c] = viewOf(state.unshot[c]);
        fields.deposit[c] = viewOf(state.recent[c]);
        fields.fresh[c] = viewOf(state.fresh[c]);
    }
    if (!state.surfaces.empty()) fields.surfaces = &state.surfaces;
    if (injecting && !state.furnace.empty()) fields.furnace = viewOf(state.furnace);
    return fields;
}

void effectiveAlbedos(const SolverState& state, int channel, std::size_t b, float* g) {
    effectiveAlbedos(state.exchange, state.escape.fit(), state.surfaces.normals(b), state.tau.brick(b),
                     state.albedoView(channel).brick(b), g);
}

ChannelPower& ChannelPower::operator+=(const ChannelPower& other) {
    for (int c = 0; c < kMaxChannels; ++c) value[c] += other.value[c];
    return *this;
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
    constants.model = state.exchange;
    constants.escape = state.escape.fit();
    constants.zeta = float(zeta);
    // A hair less than its share where shares are rounded, so that together they never take more than there is.
    constexpr float kRounding = 1e-6f;
    constants.mostShot = (beams & (beams - 1)) == 0 ? 1.0f / float(beams) : (1 - kRounding) / float(beams);
    constants.solidTau = float(state.solidTau());
    return constants;
}

Beam darkBeam(const SolverState& state, const RayFront& front) {
    Beam beam;
    beam.front = front;
    const double length =
        state.exchange == ExchangeModel::paper ? std::cbrt(state.volume.layout.voxelVolume) : front.stepLength;
    beam.stepScale = float(length / state.escape.meanStepLength());
    beam.furnaceRay = float(front.crossSection / state.voxelFace());
    return beam;
}

double thickShare(const SolverState& state) {
    const double limit = 2 * state.escape.meanStepLength() / std::cbrt(state.volume.layout.voxelVolume);
    const double thick = orderedSum(state.volume.layout.brickCount(), [&](std::size_t b) {
        const PackedNormal* const normals = state.surfaces.normals(b);
        int count = 0;
        for (int i = 0; i < kBrickVoxels; ++i)
            count += double(state.tau.brick(b)[i]) > limit && !(normals && normals[i] != 0);
        return double(count);
    });
    return thick / std::max<double>(1, double(state.volume.layout.activeVoxels));
}

}  // namespace raysweep
