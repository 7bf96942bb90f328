#include "raysweep/volume/classify.h"

#include "raysweep/core/error.h"
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
    openvdb::tools::prune(extinction->tree());
    extinction->setName("extinction");
    extinction->setGridClass(openvdb::GRID_FOG_VOLUME);
    return extinction;
}

template <class GridType, class ValueOf>
openvdb::GridBase::Ptr albedoOf(const FloatGrid& density, const FloatGrid& extinction, const ValueOf& valueOf) {
    const auto albedo = mappedGrid<GridType>(density, extinction.tree(), valueOf);
    openvdb::tools::prune(albedo->tree());
    albedo->setName("albedo");
    return albedo;
}

}  // namespace

ClassifiedVolume classify(const FloatGrid& density, const TransferFunction& exact) {
    exact.validate();
    const TransferFunction function = inSinglePrecision(exact);
    if (!density.transform().isLinear())
        throw InvalidArgument("grid '" + density.getName() +
                              "' has a transform that is not linear (a frustum?); resample it");
    checkFinite(density, density.getName().empty() ? "density" : density.getName());
    ClassifiedVolume volume{extinctionOf(density, function), nullptr};
    if (!function.coloured) return volume;
    if (isGreyEverywhere(function))
        volume.albedo = albedoOf<FloatGrid>(density, *volume.extinction, [&](float value, const Coord&) {
            return evaluate(function, double(value)).color.x;
        });
    else
        volume.albedo = albedoOf<Vec3SGrid>(density, *volume.extinction, [&](float value, const Coord&) {
            const Color color = evaluate(function, double(value)).color;
            return Vec3s(color.x, color.y, color.z);
        });
    return volume;
}

}  // namespace raysweep
