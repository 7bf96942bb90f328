#include "raysweep/scene/extremes.h"

#include "raysweep/core/brief.h"
#include "raysweep/volume/statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace raysweep {
namespace {

struct Quantity {
    std::string name;
    double value;
};

double largestIn(const openvdb::GridBase& grid) {
    const ValueRange range = valueRange(grid);
    return range.max.empty() ? 0 : double(*std::max_element(range.max.begin(), range.max.end()));
}

std::vector<Quantity> quantitiesOf(const Scene& scene) {
    const Medium& medium = scene.medium;
    std::vector<Quantity> all = {{"a density", largestIn(*medium.density)},
                                 {"an extinction per unit density", medium.extinctionScale},
                                 {"an edge of voxels", std::cbrt(std::abs(medium.density->transform().voxelVolume()))},
                                 {"a radiance of the sky", double(maxComponent(scene.sky.radiance))}};
    if (medium.emission) {
        all.push_back({"an emitted power density", largestIn(*medium.emission)});
        all.push_back({"a factor on emission", medium.emissionScale});
    }
    for (const Sun& sun : scene.suns) all.push_back({"a sun's irradiance", double(maxComponent(sun.irradiance))});
    for (const PointLight& point : scene.points) all.push_back({"a point's power", double(maxComponent(point.power))});
    for (const QuadLight& quad : scene.quads) all.push_back({"a quad's radiance", double(maxComponent(quad.radiance))});
    return all;
}

}  // namespace

std::string describeExtremes(const Scene& scene) {
    const std::vector<Quantity> all = quantitiesOf(scene);
    const auto farFrom1 = [](const Quantity& quantity) {
        return quantity.value > 0 ? std::abs(std::log10(quantity.value)) : 0;
    };
    const auto most = std::max_element(all.begin(), all.end(),
                                       [&](const Quantity& a, const Quantity& b) { return farFrom1(a) < farFrom1(b); });
    return most->name + " of " + brief(most->value, 3) +
           " leads beyond what single precision can hold; choose units in which numbers are nearer 1 (light is linear: "
           "scale it down, and the answer up)";
}

}  // namespace raysweep
