#include "raysweep/volume/similarity.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/albedo_grid.h"
#include "raysweep/volume/mapped_grid.h"
#include "raysweep/volume/voxel_check.h"

#include <openvdb/tools/Prune.h>

#include <sstream>

namespace raysweep {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;

double extinctionFactor(double albedo, double g) {
    return 1 - albedo * g;
}

float similarAlbedo(double albedo, double g) {
    return float(albedo * (1 - g) / (1 - albedo * g));
}

FloatGrid::ConstPtr requireGrey(const Medium& medium) {
    const openvdb::GridBase& albedo = *medium.albedoGrid;
    if (!albedo.isType<FloatGrid>())
        throw InvalidArgument("the albedo grid '" + albedo.getName() + "' is of type " + albedo.valueType() +
                              "; with `g` other than 0 `albedo` must be grey (float), as extinction is one for all "
                              "wavelengths");
    return openvdb::gridConstPtrCast<FloatGrid>(albedoOnDensity(medium));
}

/// Extinction voxel by voxel; the active voxels are those of the density.
FloatGrid::Ptr similarExtinction(const Medium& medium, const FloatGrid& albedo, double g) {
    // Where albedo has voxels, density must not have a tile.
    openvdb::FloatTree topology(medium.density->tree());
    topology.topologyUnion(albedo.tree());
    topology.topologyIntersection(medium.density->tree());
    const auto extinction = mappedGrid<FloatGrid>(*medium.density, topology, [&](float density, const Coord& at) {
        float value = 0;
        const double here = albedo.tree().probeValue(at, value) ? double(value) : 0.0;
        return float(double(density) * medium.extinctionScale * extinctionFactor(here, g));
    });
    openvdb::tools::prune(extinction->tree());
    extinction->setName("extinction");
    extinction->setGridClass(openvdb::GRID_FOG_VOLUME);
    return extinction;
}

}  // namespace

Medium similarIsotropicMedium(const Medium& medium, double g) {
    if (!(g > -1 && g < 1)) {
        std::ostringstream text;
        text << "g is " << g << "; a mean cosine must be in (-1,1)";
        throw InvalidArgument(text.str());
    }
    if (g == 0) return medium;
    Medium similar = medium;
    if (medium.albedoGrid) {
        const FloatGrid::ConstPtr albedo = requireGrey(medium);
        checkVoxels(*medium.density, "density");
        similar.density = similarExtinction(medium, *albedo, g);
        similar.extinctionScale = 1;
        const auto reduced = mappedGrid<FloatGrid>(
            *albedo, albedo->tree(), [&](float value, const Coord&) { return similarAlbedo(double(value), g); });
        reduced->setName(albedo->getName());
        similar.albedoGrid = reduced;
        return similar;
    }
    if (!isGrey(medium.albedo))
        throw InvalidArgument(
            "with `g` other than 0 `albedo` must be grey: one number, as extinction is one for all wavelengths");
    similar.extinctionScale *= extinctionFactor(double(medium.albedo.x), g);
    similar.albedo = grey(similarAlbedo(double(medium.albedo.x), g));
    return similar;
}

}  // namespace raysweep
