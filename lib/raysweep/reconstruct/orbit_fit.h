/// The axis that the views of a scan turn about, found from the views.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/core/types.h"

#include <optional>
#include <vector>

namespace raysweep {

struct OrbitFit {
    Vec3 axis{0};                ///< length 1, its largest coordinate is positive
    Vec3 center{0};              ///< on the axis: cone: in the sources' plane; parallel: where the detector's middle is
    double radius = 0;           ///< cone: of the sources' circle, world units
    std::vector<double> angles;  ///< of each view's source as seen from the axis, radians, in [0, 2 pi), in the axis'
                                 ///< right-handed sense

    /// Without the part along the axis.
    Vec3 inPlane(const Vec3& v) const { return v - axis * v.dot(axis); }
};

/// @throw InvalidArgument if a cone's sources do not lie on a circle (within 2 % of its radius) or are fewer than 3, or
/// if parallel rays do not all run at right angles to one axis (within 2 %) or in fewer than 2 directions.
OrbitFit fitOrbit(const ProjectionGeometry& geometry);

/// The same; nothing where that throws.
std::optional<OrbitFit> findOrbit(const ProjectionGeometry& geometry);

}  // namespace raysweep
