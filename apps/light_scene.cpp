#include "light_scene.h"

#include "raysweep/core/error.h"
#include "raysweep/volume/classify.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/similarity.h"
#include "raysweep/volume/voxel_check.h"

#include <cstdio>

namespace raysweep::apps {
namespace {

/// Runs `select`, and says on failure which option was to choose the grid.
template <class Select>
auto chosenBy(const std::string& option, const Select& select) {
    try {
        return select();
    } catch (const InvalidArgument& e) {
        throw about(option, e);
    }
}

void sayRepaired(const LightArguments& a, std::size_t count, const std::string& name, const std::string& what) {
    if (count > 0)
        warning(a.common, std::to_string(count) + (count > 1 ? " voxels" : " voxel") + " of '" + name +
                              (count > 1 ? "' were " : "' was ") + what +
                              (count > 1 ? " and count as 0" : " and counts as 0"));
}

/// A copy without voxels that light transport cannot work with; says how many there were.
template <class Grid>
typename Grid::Ptr repaired(const LightArguments& a, const Grid& grid) {
    const typename Grid::Ptr copy = grid.deepCopy();
    sayRepaired(a, repairVoxels(*copy), grid.getName(), "NaN, infinite or negative");
    return copy;
}

/// The density that is lit. Where it is none of the input's grids the output must hold what became of it.
openvdb::FloatGrid::ConstPtr densityFrom(const LightArguments& a, const VdbFile& file, LightScene& lit) {
    const openvdb::FloatGrid::Ptr density = chosenBy(
        "--density", [&] { return a.fromLevelSet ? selectLevelSet(file, a.density) : selectDensity(file, a.density); });
    lit.ownExtinction = a.fromLevelSet || a.repair;
    if (!a.repair) return density;
    if (!a.transfer.given()) return repaired(a, *density);
    // A transfer function gives negative values a meaning, too.
    const openvdb::FloatGrid::Ptr copy = density->deepCopy();
    sayRepaired(a, repairNotFinite(*copy), density->getName(), "NaN or infinite");
    return copy;
}

/// Puts what the transfer function makes of the density in its place.
void classifyMedium(const LightArguments& a, LightScene& lit) {
    Medium& medium = lit.scene.medium;
    const ClassifiedVolume classified = classify(*medium.density, *lit.transfer);
    medium.density = classified.extinction;
    medium.extinctionScale = 1;
    medium.solid = true;
    lit.ownExtinction = true;
    lit.reasons.push_back(a.transfer.ramp.empty()
                              ? "extinction: '" + lit.density + "' classified by the table '" + a.transfer.table + "'"
                              : "extinction: '" + lit.density + "' classified by the ramp " + a.transfer.ramp);
    if (!classified.albedo || !a.albedo.empty()) return;
    medium.albedoGrid = classified.albedo;
    lit.reasons.push_back("albedo: the table's colours");
}

openvdb::GridBase::ConstPtr emissionFrom(const LightArguments& a, const VdbFile& file) {
    const openvdb::GridBase::ConstPtr emission =
        chosenBy("--emission", [&] { return selectGrid(file, a.emissionGrid); });
    if (!a.repair) return emission;
    return withTypedGrid(*emission, [&](const auto& grid) -> openvdb::GridBase::ConstPtr { return repaired(a, grid); });
}

/// Scattering by a phase function of mean cosine g becomes isotropic scattering in a similar medium.
void makeIsotropic(const LightArguments& a, LightScene& lit) {
    Medium& medium = lit.scene.medium;
    const double before = medium.extinctionScale;
    try {
        medium = similarIsotropicMedium(medium, a.g);
    } catch (const InvalidArgument& e) {
        throw InvalidArgument(std::string("--g: ") + e.what());
    }
    lit.ownExtinction = lit.ownExtinction || medium.albedoGrid;
    char text[200];
    std::snprintf(text, sizeof text, "phase function: mean cosine %.3g, by similarity as an isotropic medium", a.g);
    lit.reasons.push_back(text);
    if (medium.albedoGrid) return;
    std::snprintf(text, sizeof text, " of %.4g times the extinction and albedo %.4g", medium.extinctionScale / before,
                  double(medium.albedo.x));
    lit.reasons.back() += text;
}

std::string percent(double share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
    return text;
}

}  // namespace

LightScene buildScene(const LightArguments& a, const VdbFile& file) {
    LightScene lit;
    Scene& scene = lit.scene;
    lit.transfer = transferFunction(a.transfer);
    scene.medium.density = densityFrom(a, file, lit);
    // As chosen, since a name alone does not tell "density[0]" from "density[1]".
    lit.density = a.density.empty() ? scene.medium.density->getName() : a.density;
    scene.medium.extinctionScale = a.extinction;
    scene.medium.albedo = a.uniformAlbedo;
    if (!a.albedoGrid.empty())
        scene.medium.albedoGrid = chosenBy("--albedo", [&] { return selectGrid(file, a.albedoGrid); });
    if (lit.transfer) classifyMedium(a, lit);
    if (a.g != 0) makeIsotropic(a, lit);
    if (!a.emissionGrid.empty()) scene.medium.emission = emissionFrom(a, file);
    scene.medium.emissionScale = a.emissionScale;
    scene.suns = a.sunLights;
    scene.points = a.pointLights;
    scene.quads = a.quadLights;
    lit.skySuns = addSky(a.sky, scene);
    if (lit.skySuns)
        lit.reasons.push_back("sky map: " + std::to_string(lit.skySuns->count) +
                              " sun(s) stand for its small bright parts, with " + percent(lit.skySuns->share) +
                              " of its power; the rest enters with the rays");
    return lit;
}

}  // namespace raysweep::apps
