#include "raysweep/volume/resample.h"

#include "raysweep/volume/active_values.h"
#include "raysweep/volume/albedo_grid.h"
#include "raysweep/volume/channels.h"
#include "raysweep/volume/coarsen.h"
#include "raysweep/volume/grid_transform.h"
#include "raysweep/volume/voxel_check.h"
#include "raysweep/volume/voxels_of.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/Morphology.h>

#include <algorithm>

namespace raysweep {
namespace {

using openvdb::FloatGrid;

template <class Value>
Value atMostOne(Value v) {
    for (int c = 0; c < kChannels<Value>; ++c) channel(v, c) = std::min(channel(v, c), 1.0f);
    return v;
}

/// Extinction-weighted average of the albedo: average of density x albedo over average of density.
template <class GridType>
typename GridType::Ptr coarseAlbedo(const GridType& albedo, const FloatGrid& density, const FloatGrid& coarseDensity,
                                    double resolution) {
    const auto scattering = withVoxelsOf<GridType>(density);
    setActive(*scattering, [&] {
        return [inAlbedo = albedo.getConstUnsafeAccessor(),
                inDensity = density.getConstUnsafeAccessor()](const openvdb::Coord& at) {
            typename GridType::ValueType value;
            return inAlbedo.probeValue(at, value) ? value * inDensity.getValue(at)
                                                  : openvdb::zeroVal<typename GridType::ValueType>();
        };
    });
    const auto coarse = openvdb::gridPtrCast<GridType>(coarsened(*scattering, resolution));
    setActive(*coarse, [&] {
        return [inScattering = coarse->getConstUnsafeAccessor(),
                inDensity = coarseDensity.getConstUnsafeAccessor()](const openvdb::Coord& at) {
            const float total = inDensity.getValue(at);
            return total > 0 ? atMostOne(inScattering.getValue(at) / total)
                             : openvdb::zeroVal<typename GridType::ValueType>();
        };
    });
    coarse->setName(albedo.getName());
    return coarse;
}

template <class GridType, class ShapeType>
openvdb::GridBase::Ptr sampled(const GridType& grid, const ShapeType& shape, int margin) {
    const auto result = withVoxelsOf<GridType>(shape);
    if (margin > 0)
        openvdb::tools::dilateActiveValues(result->tree(), margin, openvdb::tools::NN_FACE_EDGE_VERTEX,
                                           openvdb::tools::IGNORE_TILES);
    setActive(*result, [&] {
        return [accessor = grid.getConstUnsafeAccessor(), &grid, &shape](const openvdb::Coord& at) {
            return openvdb::tools::BoxSampler::sample(accessor, grid.worldToIndex(shape.indexToWorld(at)));
        };
    });
    result->insertMeta(grid);
    return result;
}

}  // namespace

Medium atResolution(const Medium& medium, double resolution) {
    if (resolution == 1) return medium;
    checkVoxels(*medium.density, "density");  // as it is, so that a message says where in it
    Medium coarse = medium;
    const auto density = openvdb::gridPtrCast<FloatGrid>(coarsened(*medium.density, resolution));
    coarse.density = density;
    if (medium.albedoGrid)
        coarse.albedoGrid = withTypedGrid(*albedoOnDensity(medium), [&](const auto& albedo) -> openvdb::GridBase::Ptr {
            return coarseAlbedo(albedo, *medium.density, *density, resolution);
        });
    return coarse;
}

openvdb::GridBase::Ptr sampledOnto(const openvdb::GridBase& grid, const openvdb::GridBase& shape, int margin) {
    requireLinear(grid);
    requireLinear(shape);
    return withTypedGrid(grid, [&](const auto& typed) {
        return withTypedGrid(shape, [&](const auto& typedShape) -> openvdb::GridBase::Ptr {
            return sampled(typed, typedShape, margin);
        });
    });
}

}  // namespace raysweep
