#include "raysweep/illuminate/plan.h"

namespace raysweep {
namespace {

bool isColoured(const openvdb::GridBase::ConstPtr& grid) {
    return grid && grid->isType<openvdb::Vec3SGrid>();
}

bool isBlack(const Color& c) {
    return maxComponent(c) <= 0;
}

bool isColoured(const Scene& scene) {
    bool coloured = isColoured(scene.medium.albedoGrid) || isColoured(scene.medium.emission);
    coloured = coloured || (!scene.medium.albedoGrid && !isGrey(scene.medium.albedo)) || !isGrey(scene.sky.radiance) ||
               scene.sky.colouredProfile;
    for (const Sun& sun : scene.suns) coloured = coloured || !isGrey(sun.irradiance);
    for (const PointLight& point : scene.points) coloured = coloured || !isGrey(point.power);
    for (const QuadLight& quad : scene.quads) coloured = coloured || !isGrey(quad.radiance);
    return coloured;
}

std::string exchangeReason(Exchange exchange, bool solid) {
    switch (exchange) {
        case Exchange::automatic:
            return solid
                       ? "exchange: surfaces where opacity changes quickly, medium elsewhere, since the volume is solid"
                       : "exchange: medium in every voxel, no gradients, since the volume is a fog";
        case Exchange::medium:
            return "exchange: medium in every voxel, no gradients, as asked";
        case Exchange::surface:
            return "exchange: surfaces where opacity changes quickly, medium elsewhere, as asked";
        case Exchange::paper:
            return solid ? "exchange: the paper's Algorithm 1 as printed, with surfaces"
                         : "exchange: the paper's Algorithm 1 as printed";
    }
    return "";
}

}  // namespace

Plan planIllumination(const Scene& scene, const IlluminateOptions& options) {
    const Medium& medium = scene.medium;
    Plan plan;
    plan.channels = isColoured(scene) ? 3 : 1;
    plan.reasons.push_back(plan.channels == 1 ? "one wavelength: light, albedo and emission are grey"
                                              : "three wavelengths: light, albedo or emission is coloured");
    plan.directPass = !scene.suns.empty() || !scene.points.empty();
    if (plan.directPass)
        plan.reasons.push_back("direct pass: " + std::to_string(scene.suns.size()) + " sun(s), " +
                               std::to_string(scene.points.size()) + " point light(s)");
    const bool sky = !isBlack(scene.sky.radiance), emits = medium.emission || !scene.quads.empty();
    const bool scatters = medium.albedoGrid || !isBlack(medium.albedo);
    plan.sweeps = scatters && options.sweeps > 0 && (plan.directPass || sky || emits);
    plan.unshotGrid = scatters && (plan.directPass || sky || emits);
    if (!scatters)
        plan.reasons.push_back("no sweeps, no unshot grid: with albedo 0 nothing is scattered");
    else if (!plan.unshotGrid)
        plan.reasons.push_back("no sweeps: there is no light");
    else if (!plan.sweeps)
        plan.reasons.push_back("no sweeps: direct light only");
    if (medium.emission)
        plan.reasons.push_back(
            "emission: its power is added to what is unshot, no direct pass; it shows by itself, apart from radiosity");
    if (!scene.quads.empty())
        plan.reasons.push_back(std::to_string(scene.quads.size()) +
                               " quad light(s): power is added to what is unshot, no direct pass");
    if (sky && plan.sweeps) plan.reasons.push_back("sky: enters with the rays of each sweep, no direct pass");
    plan.reasons.push_back(medium.albedoGrid ? "albedo from grid '" + medium.albedoGrid->getName() + "'"
                                             : "albedo is uniform and not stored");
    plan.surfaces = options.exchange == Exchange::surface || (options.exchange != Exchange::medium && medium.solid);
    plan.reasons.push_back(exchangeReason(options.exchange, medium.solid));
    return plan;
}

}  // namespace raysweep
