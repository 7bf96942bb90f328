#include "raysweep/illuminate/sweep_recorder.h"

#include "raysweep/bricks/field_grids.h"
#include "raysweep/core/parallel.h"

namespace raysweep {
namespace {

/// Normals as the sweeps have them.
openvdb::GridBase::Ptr normalGrid(const SolverState& state, const openvdb::math::Transform& transform) {
    const BrickLayout& layout = state.medium.volume.layout;
    BrickField components[3];
    for (BrickField& component : components) component = BrickField(layout.brickCount());
    for (std::size_t b = 0; b < layout.brickCount(); ++b) {
        const PackedNormal* const normals = state.solid.surfaces.normals(b);
        for (int i = 0; normals && i < kBrickVoxels; ++i) {
            if (!isSurface(normals[i])) continue;
            const Vec3 normal = unpackNormal(normals[i]);
            for (int axis = 0; axis < 3; ++axis) components[axis].brick(b)[i] = float(normal[axis]);
        }
    }
    return sparseGridFromFields(layout, transform, components, 3);
}

}  // namespace

void recordScene(IlluminationRecord& record, const SolverState& state, const Scene& scene,
                 const IlluminateOptions& options) {
    const MediumFields& medium = state.medium;
    const BrickLayout& layout = medium.volume.layout;
    const auto gridOf = [&](const BrickField* fields) {
        return sparseGridFromFields(layout, scene.medium.density->transform(), fields, medium.channels);
    };
    record = IlluminationRecord();
    record.low = layout.low;
    record.high = layout.high;
    record.worldFromIndex = layout.worldFromIndex;
    record.asPrinted = medium.model == ExchangeModel::asPrinted;
    record.interpolation = options.interpolation;
    record.channels = medium.channels;
    record.suns = scene.suns;
    record.otherSources = !scene.points.empty() || !scene.quads.empty() || scene.medium.emission;
    // With a white furnace no voxel's radiosity is that of a medium alone.
    constexpr double kAny = 1e-30;
    if (state.solid.present) record.surfaceOpacity = state.solid.surfaces.mixed ? kAny : options.surfaceThreshold;
    if (!state.solid.surfaces.empty()) record.normals = normalGrid(state, scene.medium.density->transform());
    record.powerUnit = state.power.unit;
    record.extinction = extinctionGrid(scene.medium);
    if (medium.uniformAlbedo)
        for (int c = 0; c < medium.channels; ++c) record.albedo[c] = double(medium.albedo[c].brick(0)[0]);
    else
        record.albedoGrid = gridOf(medium.albedo);
    if (state.power.hasSource()) record.source = gridOf(state.power.source);
    if (!state.power.scattered[0].empty()) record.scattered = gridOf(state.power.scattered);
    for (auto* const unknown : {&record.deposit, &record.unshot})  // until there are sweeps
        *unknown = sparseGridFromFields({}, scene.medium.density->transform(), nullptr, medium.channels);
}

void SweepRecorder::begin(const ExchangeConstants& constants, bool fromCoarse) {
    record_.zeta = double(constants.zeta);
    record_.mostShot = double(constants.mostShot);
    if (fromCoarse) record_.unshotStart = gridOf(state_.power.unshot);
}

void SweepRecorder::end() {
    record_.injections = state_.power.injections;
    for (int c = 0; c < state_.medium.channels; ++c) deposit_.push_back(depositOf(c));
    record_.deposit = gridOf(deposit_.data());
    record_.unshot = gridOf(state_.power.unshot);
}

void SweepRecorder::settle(bool onCoarse) {
    record_.settled = onCoarse;
    for (int c = 0; c < state_.medium.channels; ++c) {
        const BrickField now = depositOf(c);
        BrickField& difference = deposit_[std::size_t(c)];
        parallelFor(now.brickCount(), [&](std::size_t b) {
            for (int i = 0; i < kBrickVoxels; ++i) difference.brick(b)[i] = now.brick(b)[i] - difference.brick(b)[i];
        });
    }
    const openvdb::GridBase::Ptr settled = gridOf(deposit_.data());
    if (settled->activeVoxelCount() > 0) record_.settledDeposit = settled;
    deposit_.clear();
}

openvdb::GridBase::Ptr SweepRecorder::gridOf(const BrickField* fields) const {
    return sparseGridFromFields(state_.medium.volume.layout, transform_, fields, state_.medium.channels);
}

BrickField SweepRecorder::depositOf(int channel) const {
    const BrickField &total = state_.power.total[channel], &recent = state_.power.recent[channel];
    BrickField deposit(total.brickCount());
    parallelFor(deposit.brickCount(), [&](std::size_t b) {
        for (int i = 0; i < kBrickVoxels; ++i) deposit.brick(b)[i] = total.brick(b)[i] + recent.brick(b)[i];
    });
    return deposit;
}

}  // namespace raysweep
