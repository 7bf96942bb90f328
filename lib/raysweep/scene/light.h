/// Light sources.
#pragma once

#include "raysweep/core/types.h"

#include <functional>

namespace raysweep {

/// Parallel light from infinitely far away.
struct Sun {
    Vec3 direction{0, -1, 0};    ///< in which the light travels, world; any length but 0
    Color irradiance = grey(1);  ///< at normal incidence, W/world unit^2
};

/// A point that shines evenly in all directions, inside or outside the volume.
struct PointLight {
    Vec3 position{0};       ///< world units
    Color power = grey(1);  ///< W
};

/// A parallelogram that shines to one side, evenly, as a Lambert emitter. It lights but is not seen: it has no
/// extinction.
struct QuadLight {
    Vec3 corner{0};               ///< world units
    Vec3 u{1, 0, 0}, v{0, 1, 0};  ///< edges from the corner, world units; light leaves towards u x v
    Color radiance = grey(1);     ///< W m^-2 sr^-1
};

/// Light from all around, infinitely far away.
struct Sky {
    Color radiance = grey(0);  ///< W m^-2 sr^-1
    /// Optional factor on `radiance`, per wavelength, for light that travels in a (unit, world) direction; not
    /// negative; none: 1 everywhere.
    std::function<Color(const Vec3& direction)> profile;
    bool colouredProfile = false;  ///< `profile` differs between wavelengths
};

}  // namespace raysweep
