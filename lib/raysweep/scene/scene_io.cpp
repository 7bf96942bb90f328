#include "raysweep/scene/scene_io.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/require.h"
#include "raysweep/image/image_io.h"
#include "raysweep/scene/lit_file.h"
#include "raysweep/volume/active_values.h"
#include "raysweep/volume/classify.h"
#include "raysweep/volume/cycles_export.h"
#include "raysweep/volume/grid_select.h"
#include "raysweep/volume/similarity.h"
#include "raysweep/volume/statistics.h"
#include "raysweep/volume/voxel_check.h"

#include <cmath>
#include <cstdio>

namespace raysweep {
namespace {

const Color kAlbedo = grey(0.9f);  ///< where nothing else is said

/// What `make` returns; its errors are about an option's `field`.
template <class Make>
auto forField(const std::string& field, const Make& make) {
    try {
        return make();
    } catch (const InvalidArgument& e) {
        throw about(field, e);
    }
}

void note(std::vector<Repair>& repairs, const Repair& repair) {
    if (repair.voxels > 0) repairs.push_back(repair);
}

/// A copy without voxels that light transport cannot work with.
template <class Grid>
typename Grid::Ptr repaired(const Grid& grid, std::vector<Repair>& repairs) {
    const typename Grid::Ptr copy = grid.deepCopy();
    note(repairs, {grid.getName(), repairVoxels(*copy), Repair::Kind::negative});
    return copy;
}

/// The density that is lit. Where it is none of the file's grids, files of results must hold what became of it.
openvdb::FloatGrid::ConstPtr densityFrom(const VdbFile& file, const MediumOptions& options, SceneOrigin& origin) {
    const openvdb::FloatGrid::Ptr density = forField("density", [&] {
        return options.levelSet ? selectLevelSet(file, options.density) : selectDensity(file, options.density);
    });
    // As chosen, since a name alone does not tell "density[0]" from "density[1]".
    origin.density = options.density.empty() ? density->getName() : options.density;
    origin.ownExtinction = options.levelSet || options.repair;
    if (!options.repair) return density;
    if (!origin.classification) return repaired(*density, origin.repairs);
    // A transfer function gives negative values a meaning, too.
    const openvdb::FloatGrid::Ptr copy = density->deepCopy();
    note(origin.repairs, {density->getName(), repairNotFinite(*copy), Repair::Kind::notFinite});
    return copy;
}

std::string nameOf(const Classification& classification) {
    if (!classification.ramp.empty()) return "the ramp " + classification.ramp;
    return classification.file.empty() ? "a table" : "the table '" + classification.file + "'";
}

/// Puts what the transfer function makes of the density in its place. Its colours are the albedo unless `albedoGiven`.
void classifyMedium(Medium& medium, bool albedoGiven, SceneOrigin& origin) {
    const ClassifiedVolume classified = classify(*medium.density, origin.classification->function);
    const ValueRange values = valueRange(*medium.density);
    if (classified.extinction->empty() && !values.min.empty())
        origin.nothingOpaque = "'" + origin.density + "' has values from " + brief(values.min[0]) + " to " +
                               brief(values.max[0]) + ", to none of which " + nameOf(*origin.classification) +
                               " gives any opacity";
    medium.density = classified.extinction;
    medium.extinctionScale = 1;
    medium.solid = true;
    origin.ownExtinction = true;
    origin.reasons.push_back("extinction: '" + origin.density + "' classified by " + nameOf(*origin.classification));
    if (!classified.albedo || albedoGiven) return;
    medium.albedoGrid = classified.albedo;
    origin.reasons.push_back("albedo: the table's colours");
}

openvdb::GridBase::ConstPtr emissionFrom(const VdbFile& file, const MediumOptions& options, SceneOrigin& origin) {
    const openvdb::GridBase::ConstPtr emission =
        forField("emission", [&] { return selectGrid(file, options.emission); });
    if (!options.repair) return emission;
    return withTypedGrid(
        *emission, [&](const auto& grid) -> openvdb::GridBase::ConstPtr { return repaired(grid, origin.repairs); });
}

/// Scaled first; what is outside of [0,1] then is repaired.
openvdb::GridBase::ConstPtr albedoFrom(const VdbFile& file, const MediumOptions& options, SceneOrigin& origin) {
    const openvdb::GridBase::ConstPtr albedo = forField("albedo", [&] { return selectGrid(file, options.albedoGrid); });
    if (!options.repair && options.albedoScale == 1) return albedo;
    return withTypedGrid(*albedo, [&](const auto& grid) -> openvdb::GridBase::ConstPtr {
        const auto copy = grid.deepCopy();
        const auto scale = float(options.albedoScale);
        if (scale != 1) forEachActive(*copy, [&](auto& value, const openvdb::CoordBBox&) { value *= scale; });
        if (options.repair) note(origin.repairs, {grid.getName(), clampAlbedo(*copy), Repair::Kind::fraction});
        return copy;
    });
}

/// Scattering by a phase function of mean cosine g becomes isotropic scattering in a similar medium.
void makeIsotropic(Medium& medium, double g, SceneOrigin& origin) {
    const double before = medium.extinctionScale;
    medium = forField("g", [&] { return similarIsotropicMedium(medium, g); });
    origin.ownExtinction = origin.ownExtinction || medium.albedoGrid;
    char text[200];
    std::snprintf(text, sizeof text, "phase function: mean cosine %.3g, by similarity as an isotropic medium", g);
    origin.reasons.push_back(text);
    if (medium.albedoGrid) return;
    std::snprintf(text, sizeof text, " of %.4g times the extinction and albedo %.4g", medium.extinctionScale / before,
                  double(medium.albedo.x));
    origin.reasons.back() += text;
}

std::string percent(double share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
    return text;
}

SkyMapLight readSkyMap(const SkyOptions& options) {
    try {
        return lightFromSkyMap(readImage(options.map), options.mapping);
    } catch (const InvalidArgument& e) {
        throw about("sky", about("'" + options.map + "'", e));
    } catch (const IoError& e) {
        throw about("sky", e);
    }
}

/// Adds the sky to the scene, and the suns that stand for bright parts of a map.
void addSky(const SkyOptions& options, SceneFromFile& made) {
    made.scene.sky.radiance = options.radiance;
    if (options.map.empty()) return;
    const SkyMapLight light = readSkyMap(options);
    made.scene.sky = light.sky;
    made.scene.suns.insert(made.scene.suns.end(), light.suns.begin(), light.suns.end());
    made.origin.skySuns = SkySuns{int(light.suns.size()), light.sunShare};
    made.origin.reasons.push_back("sky map: " + std::to_string(light.suns.size()) +
                                  " sun(s) stand for its small bright parts, with " + percent(light.sunShare) +
                                  " of its power; the rest enters with the rays");
}

bool isFactor(double value) {
    return value >= 0 && std::isfinite(value);
}

}  // namespace

void MediumOptions::validate() const {
    if (extinction) requireField(isFactor(*extinction), "extinction", *extinction, "finite and not negative");
    if (classification) classification->function.validate();
    for (int c = 0; albedo && c < 3; ++c)
        requireField((*albedo)[c] >= 0 && (*albedo)[c] <= 1, "albedo", (*albedo)[c], "in [0, 1]");
    requireField(isFactor(albedoScale), "albedoScale", albedoScale, "finite and not negative");
    requireField(g > -1 && g < 1, "g", g, "in (-1, 1)");
    requireField(isFactor(emissionScale), "emissionScale", emissionScale, "finite and not negative");
}

void SkyOptions::validate() const {
    for (int c = 0; c < 3; ++c)
        requireField(isFactor(double(radiance[c])), "sky radiance", radiance[c], "finite and not negative");
    mapping.validate();
}

void SceneOptions::validate() const {
    medium.validate();
    sky.validate();
}

MediumFromFile mediumFrom(const VdbFile& file, const MediumOptions& options) {
    options.validate();
    requireOriginal(file);
    const VdbFile grids = withoutLight(file);
    MediumFromFile made;
    auto& [medium, origin] = made;
    origin.classification = options.classification;
    if (options.isClassified() && !origin.classification)
        origin.classification = Classification{rampFunction(0, 1), "0,1", ""};
    medium.density = densityFrom(grids, options, origin);
    medium.extinctionScale = options.extinction.value_or(1);
    medium.albedo = options.albedo.value_or(kAlbedo);
    if (!options.albedoGrid.empty()) medium.albedoGrid = albedoFrom(grids, options, origin);
    if (origin.classification) classifyMedium(medium, options.albedo || medium.albedoGrid, origin);
    if (options.g != 0) makeIsotropic(medium, options.g, origin);
    if (!options.emission.empty()) medium.emission = emissionFrom(grids, options, origin);
    medium.emissionScale = options.emissionScale;
    return made;
}

SceneFromFile sceneFrom(const VdbFile& file, const SceneOptions& options) {
    options.validate();
    SceneFromFile made;
    const MediumFromFile lit = mediumFrom(file, options.medium);
    made.scene.medium = lit.medium;
    made.origin = lit.origin;
    made.scene.suns = options.suns;
    made.scene.points = options.points;
    made.scene.quads = options.quads;
    addSky(options.sky, made);
    return made;
}

}  // namespace raysweep
