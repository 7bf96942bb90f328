#include "raysweep/illuminate/emission.h"

#include "raysweep/bricks/brick_map.h"
#include "raysweep/core/memory.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/cycles_export.h"
#include "raysweep/volume/deposit.h"
#include "raysweep/volume/overlap.h"
#include "raysweep/volume/voxel_check.h"
#include "raysweep/volume/voxels_of.h"

namespace raysweep {
namespace {

/// Part of a voxel that lies in surface voxels of a solid; those of quad lights in empty space are none.
double surfaceShare(const SolverState& state, const Overlap& overlap, const openvdb::Coord& voxel) {
    double share = 0;
    overlap.forEachPart({voxel, voxel}, [&](const openvdb::Coord& at, double part) {
        const Index3 here(at.x(), at.y(), at.z());
        const std::uint32_t b = state.medium.volume.map.find(here);
        if (b == kNoBrick) return;
        const PackedNormal* const normals = state.solid.surfaces.normals(b);
        const std::size_t i = offsetInBrick(here);
        if (normals && isSurface(normals[i]) && state.medium.tau.brick(b)[i] > 0) share += part;
    });
    return share;
}

/// Takes away what lies in surfaces. @return false if nothing is left
template <class GridType>
bool leaveOutSurfaces(GridType& grid, const SolverState& state, const openvdb::math::Transform& transform) {
    constexpr double kRounding = 1e-6;
    const Overlap overlap(grid, transform);
    bool any = false;
    forEachActive(grid, [&](auto& value, const openvdb::CoordBBox& box) {
        const double share = surfaceShare(state, overlap, box.min());
        value *= share > 1 - kRounding ? 0.0f : share > kRounding ? float(1 - share) : 1.0f;
        any = any || value != openvdb::zeroVal<typename GridType::ValueType>();
    });
    return any;
}

template <class GridType>
openvdb::GridBase::Ptr shownGrid(const GridType& emission, const SolverState& state, const Medium& medium) {
    const auto inLeaves = emission.tree().activeLeafVoxelCount();
    const double leaves =
        double(emission.tree().leafCount()) + double(emission.activeVoxelCount() - inLeaves) / kBrickVoxels;
    requireMemory(leaves, sizeof(typename GridType::ValueType));
    const auto shown = withVoxelsOf<GridType>(emission);
    const auto scale = float(medium.emissionScale);
    setActive(*shown, [&] {
        return
            [&, in = emission.getConstUnsafeAccessor()](const openvdb::Coord& at) { return in.getValue(at) * scale; };
    });
    shown->setName("emission");
    if (state.solid.present && !leaveOutSurfaces(*shown, state, medium.density->transform())) return nullptr;
    extendForCycles(*shown);
    return shown;
}

}  // namespace

openvdb::GridBase::ConstPtr emissionOnVoxels(const Medium& medium) {
    if (!medium.emission) return nullptr;
    withTypedGrid(*medium.emission, [](const auto& grid) { checkVoxels(grid, "emission"); });
    return depositedOnto(medium.emission, medium.density->transform());
}

openvdb::GridBase::Ptr shownEmission(const SolverState& state, const Medium& medium) {
    if (!medium.emission) return nullptr;
    return withTypedGrid(*medium.emission, [&](const auto& typed) { return shownGrid(typed, state, medium); });
}

EmittedShares emittedShares(const MediumFields& medium, double tau, double albedo) {
    // In the paper's exchange a voxel's power leaves it whole.
    if (medium.model == ExchangeModel::asPrinted) return {1, 0};
    const EscapeFit& fit = medium.escape.fit();
    const double leaving = leavingShare(albedo, fit.probability(tau));
    return {leaving, leaving * albedo * fit.collision(tau)};
}

}  // namespace raysweep
