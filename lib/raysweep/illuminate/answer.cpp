#include "raysweep/illuminate/answer.h"

#include "raysweep/bricks/field_grids.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/radiosity.h"

#include <algorithm>

namespace raysweep {
namespace {

openvdb::GridBase::Ptr radiosityGrid(const SolverState& state, const Scene& scene,
                                     const std::vector<BrickField>& radiosity) {
    auto grid = extendedGridFromFields(state.medium.volume.layout, *scene.medium.density, radiosity);
    grid->setName("radiosity");
    return grid;
}

}  // namespace

openvdb::GridBase::Ptr snapshotGrid(const SolverState& state, const Scene& scene, bool spread) {
    std::vector<BrickField> radiosity;
    for (int c = 0; c < state.medium.channels; ++c) {
        radiosity.emplace_back(state.medium.volume.layout.brickCount());
        computeRadiosity(state, c, spread ? spreadUnshot(state, c) : BrickField(), radiosity.back());
    }
    return radiosityGrid(state, scene, radiosity);
}

openvdb::GridBase::Ptr finalGrid(SolverState& state, const Scene& scene) {
    std::vector<BrickField> radiosity;
    for (int c = 0; c < state.medium.channels; ++c) {
        BrickField& field = state.power.total[c];
        const bool swept = !field.empty();
        BrickField own = swept ? BrickField() : BrickField(state.medium.volume.layout.brickCount());
        computeRadiosity(state, c, BrickField(), swept ? field : own);
        radiosity.push_back(std::move(swept ? field : own));
        state.power.recent[c] = BrickField();
        state.power.scattered[c] = BrickField();
    }
    // Without a sweep the sources are what is unshot, and still needed.
    if (state.power.injections > 0)
        for (BrickField& source : state.power.source) source = BrickField();
    return radiosityGrid(state, scene, radiosity);
}

openvdb::GridBase::Ptr unshotGrid(SolverState& state, const Scene& scene) {
    const bool swept = !state.power.unshot[0].empty();
    if (!swept && !state.power.hasSource()) return nullptr;
    std::vector<BrickField> fields;
    for (int c = 0; c < state.medium.channels; ++c) {
        fields.push_back(std::move(swept ? state.power.unshot[c] : state.power.source[c]));
        const double scale = state.power.unit / std::max(1, state.power.injections);
        parallelFor(
            fields.back().brickCount(),
            [&](std::size_t b) {
                for (int i = 0; i < kBrickVoxels; ++i) fields.back().brick(b)[i] *= float(scale);
            },
            16);
    }
    auto grid = gridFromFields(state.medium.volume.layout, *scene.medium.density, fields);
    grid->setName("unshot");
    return grid;
}

}  // namespace raysweep
