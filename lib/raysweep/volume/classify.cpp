#include "raysweep/volume/classify.h"

#include "raysweep/volume/grid_transform.h"
#include "raysweep/volume/mapped_grid.h"
#include "raysweep/volume/voxel_check.h"

#include <openvdb/tools/Activate.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

bool isGreyEverywhere(const TransferFunction& function) {
    return std::all_of(function.points.begin(), function.points.end(),
                       [](const TransferPoint& point) { return isGrey(point.color); });
}

/// Grids hold floats: a voxel of 0.2 is above the double 0.2, and would not be "at" a point there.
TransferFunction inSinglePrecision(TransferFunction function) {
    constexpr double kLargest = double(std::numeric_limits<float>::max());
    for (TransferPoint& point : function.points)
        point.value = double(float(std::min(kLargest, std::max(-kLargest, point.value))));
    return function;
}

FloatGrid::Ptr extinctionOf(const FloatGrid& density, const TransferFunction& function) {
    const double edge = std::cbrt(std::abs(density.transform().voxelVolume()));
    const auto extinction = mappedGrid<FloatGrid>(density, density.tree(), [&](float value, const Coord&) {
        return float(extinctionFromOpacity(evaluate(function, double(value)).opacity, edge));
    });
    openvdb::tools::deactivate(extinction->tree(), 0.0f);
    extinction->setName("extinction");
    extinction->setGridClass(openvdb::GRID_FOG_VOLUME);
    return extinction;
}

template <class GridType, class ColorOf>
openvdb::GridBase::Ptr albedoOf(const FloatGrid& density, const FloatGrid& extinction, const TransferFunction& function,
                                const ColorOf& colorOf) {
    const auto albedo = mappedGrid<GridType>(density, extinction.tree(), [&](float value, const Coord&) {
        return colorOf(evaluate(function, double(value)).color);
    });
    openvdb::tools::prune(albedo->tree());
    albedo->setName("albedo");
    return albedo;
}

openvdb::GridBase::Ptr albedoOf(const FloatGrid& density, const FloatGrid& extinction,
                                const TransferFunction& function) {
    if (isGreyEverywhere(function))
        return albedoOf<FloatGrid>(density, extinction, function, [](const Color& c) { return c.x; });
    return albedoOf<Vec3SGrid>(density, extinction, function, [](const Color& c) { return Vec3s(c.x, c.y, c.z); });
}

}  // namespace

ClassifiedVolume classify(const FloatGrid& density, const TransferFunction& exact) {
    exact.validate();
    const TransferFunction function = inSinglePrecision(exact);
    requireLinear(density);
    checkFinite(density, density.getName().empty() ? "density" : density.getName());
    ClassifiedVolume volume{extinctionOf(density, function), nullptr};
    // Not pruned before the albedo has been made from its voxels: equal opacities may have different colours.
    if (function.coloured) volume.albedo = albedoOf(density, *volume.extinction, function);
    openvdb::tools::prune(volume.extinction->tree());
    return volume;
}

}  // namespace raysweep
