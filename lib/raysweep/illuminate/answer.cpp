#include "raysweep/illuminate/answer.h"

#include "raysweep/bricks/field_grids.h"
#include "raysweep/core/parallel.h"
#include "raysweep/illuminate/estimate.h"

#include <algorithm>

namespace raysweep {
namespace {

openvdb::GridBase::Ptr radiosityGrid(const SolverState& state, const Scene& scene,
                                     const std::vector<BrickField>& radiosity) {
    auto grid = extendedGridFromFields(state.volume.layout, *scene.medium.density, radiosity);
    grid->setName("radiosity");
    return grid;
}

}  // namespace

openvdb::GridBase::Ptr snapshotGrid(const SolverState& state, const Scene& scene, bool spread) {
    std::vector<BrickField> radiosity;
    for (int c = 0; c < state.channels; ++c) {
        radiosity.emplace_back(state.volume.layout.brickCount());
        computeRadiosity(state, c, spread ? spreadUnshot(state, c) : BrickField(), radiosity.back());
    }
    return radiosityGrid(state, scene, radiosity);
}

openvdb::GridBase::Ptr finalGrid(SolverState& state, const Scene& scene) {
    std::vector<BrickField> radiosity;
    for (int c = 0; c < state.channels; ++c) {
        BrickField& field = state.total[c];
        const bool swept = !field.empty();
        BrickField own = swept ? BrickField() : BrickField(state.volume.layout.brickCount());
        computeRadiosity(state, c, BrickField(), swept ? field : own);
        radiosity.push_back(std::move(swept ? field : own));
        state.recent[c] = BrickField();
    }
    // Without a sweep the sources are what is unshot, and still needed.
    if (state.injections > 0)
        for (BrickField& source : state.source) source = BrickField();
    return radiosityGrid(state, scene, radiosity);
}

openvdb::GridBase::Ptr unshotGrid(SolverState& state, const Scene& scene) {
    const bool swept = !state.unshot[0].empty();
    if (!swept && !state.hasSource()) return nullptr;
    std::vector<BrickField> fields;
    for (int c = 0; c < state.channels; ++c) {
        fields.push_back(std::move(swept ? state.unshot[c] : state.source[c]));
        const double scale = state.powerUnit / std::max(1, state.injections);
        parallelFor(
            fields.back().brickCount(),
            [&](std::size_t b) {
                for (int i = 0; i < kBrickVoxels; ++i) fields.back().brick(b)[i] *= float(scale);
            },
            16);
    }
    auto grid = gridFromFields(state.volume.layout, *scene.medium.density, fields);
    grid->setName("unshot");
    return grid;
}

}  // namespace raysweep
