#include "raysweep/scene/scene.h"

#include "raysweep/core/finite.h"
#include "raysweep/core/require.h"

#include <cmath>

namespace raysweep {
namespace {

void requireLight(const char* what, const Color& c) {
    for (int i = 0; i < 3; ++i) requireField(std::isfinite(c[i]) && c[i] >= 0, what, c[i], "finite and not negative");
}

void requireFactor(const char* what, double value) {
    requireField(value >= 0 && value <= 1e30, what, value, "in [0, 1e30]");
}

}  // namespace

void Scene::validate() const {
    if (!medium.density) throw InvalidArgument("the scene has no density grid");
    requireFactor("extinction", medium.extinctionScale);
    requireFactor("emission scale", medium.emissionScale);
    for (int c = 0; c < 3; ++c)
        requireField(medium.albedo[c] >= 0 && medium.albedo[c] <= 1, "albedo", medium.albedo[c], "in [0, 1]");
    for (const Sun& sun : suns) {
        if (!isDirection(sun.direction))
            throw InvalidArgument("a sun's direction has no length; give the direction in which its light travels");
        requireLight("a sun's irradiance", sun.irradiance);
    }
    for (const PointLight& point : points) {
        if (!isFinite(point.position)) throw InvalidArgument("a point light's position is not finite");
        requireLight("a point light's power", point.power);
    }
    for (const QuadLight& quad : quads) {
        if (!isFinite(quad.corner) || !isFinite(quad.u) || !isFinite(quad.v))
            throw InvalidArgument("a quad light's corner or edges are not finite");
        if (!(quad.u.cross(quad.v).length() > 1e-9 * quad.u.length() * quad.v.length()))
            throw InvalidArgument("a quad light has no area: its edges are parallel, or one has no length");
        requireLight("a quad light's radiance", quad.radiance);
    }
    requireLight("the sky's radiance", sky.radiance);
}

}  // namespace raysweep
