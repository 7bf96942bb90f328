/// Detectors that stand in other ways than upright ones.
#pragma once

#include <cmath>
#include <utility>

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/core/types.h"

namespace raysweep::test {

/// Turns each detector about its middle. @param turn gives for a view the axis, and the angle in degrees
template <class Turn>
void turnDetectors(ProjectionGeometry& geometry, const Turn& turn) {
    for (XrayView& view : geometry.views) {
        const double x = 0.5 * (geometry.width - 1), y = 0.5 * (geometry.height - 1);
        const Vec3 middle = view.pixel(x, y);
        const auto [about, degrees] = turn(view);
        const Vec3 axis = about.normalized();
        const double c = std::cos(degrees * kPi / 180), s = std::sin(degrees * kPi / 180);
        for (Vec3* v : {&view.column, &view.row}) *v = *v * c + axis.cross(*v) * s + axis * (axis.dot(*v) * (1 - c));
        view.origin = middle - view.column * x - view.row * y;
    }
}

/// `geometry` with each detector turned within its plane.
inline ProjectionGeometry rolled(ProjectionGeometry geometry, double degrees) {
    turnDetectors(geometry, [&](const XrayView& view) { return std::pair(view.column.cross(view.row), degrees); });
    return geometry;
}

}  // namespace raysweep::test
