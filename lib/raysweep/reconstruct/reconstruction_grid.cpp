#include "raysweep/reconstruct/reconstruction_grid.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/orbit_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace raysweep {
namespace {

/// What a geometry sees, relative to the point `center` of its axis. World units.
struct Seen {
    double radius = 0;                                     ///< about the axis
    double low = std::numeric_limits<double>::infinity();  ///< along the axis
    double high = -std::numeric_limits<double>::infinity();
    double pixel = std::numeric_limits<double>::infinity();  ///< smaller edge of a pixel, at the axis
};

Seen seenOf(const ProjectionGeometry& geometry, const OrbitFit& orbit) {
    const bool cone = geometry.beam == BeamShape::cone;
    const double middleX = 0.5 * (geometry.width - 1), middleY = 0.5 * (geometry.height - 1);
    Seen seen;
    for (const XrayView& view : geometry.views) {
        // Of the way from source to detector, the part that leads to the axis; parallel rays do not spread.
        const Vec3 normal = view.column.cross(view.row);
        const double part = cone ? normal.dot(orbit.center - view.source) / normal.dot(view.origin - view.source) : 1;
        seen.pixel = std::min({seen.pixel, part * view.column.length(), part * view.row.length()});
        for (const double x : {-0.5, geometry.width - 0.5}) {
            const Vec3 p = view.pixel(x, middleY);
            const Vec3 ray = orbit.inPlane(cone ? p - view.source : view.direction).normalized();
            seen.radius = std::max(seen.radius, ray.cross(orbit.inPlane(orbit.center - p)).length());
        }
        for (const double y : {-0.5, geometry.height - 0.5}) {
            const Vec3 p = view.pixel(middleX, y);
            const double height =
                (cone ? view.source + (p - view.source) * part - orbit.center : p - orbit.center).dot(orbit.axis);
            seen.low = std::min(seen.low, height);
            seen.high = std::max(seen.high, height);
        }
    }
    return seen;
}

}  // namespace

openvdb::math::Transform::Ptr ReconstructionGrid::transform() const {
    const auto transform = openvdb::math::Transform::createLinearTransform(spacing);
    const Vec3 first = voxel(0, 0, 0);
    transform->postTranslate(openvdb::Vec3d(first.x, first.y, first.z));
    return transform;
}

void ReconstructionGrid::validate() const {
    for (int axis = 0; axis < 3; ++axis) {
        const std::string number = "[" + std::to_string(axis) + "]";
        requireField(dims[axis] >= 1, "reconstruction grid dims" + number, dims[axis], "at least 1");
        requireField(std::isfinite(center[axis]), "reconstruction grid center" + number, center[axis], "finite");
    }
    requireField(spacing > 0 && std::isfinite(spacing), "reconstruction grid spacing", spacing, "positive and finite");
}

ReconstructionGrid coveringGrid(const ProjectionGeometry& geometry) {
    const OrbitFit orbit = fitOrbit(geometry);
    const Seen seen = seenOf(geometry, orbit);
    ReconstructionGrid grid;
    grid.spacing = seen.pixel;
    grid.center = orbit.center + orbit.axis * (0.5 * (seen.low + seen.high));
    for (int axis = 0; axis < 3; ++axis) {
        // The box about an upright or tilted cylinder.
        const double along = std::abs(orbit.axis[axis]), aside = std::sqrt(std::max(0.0, 1 - along * along));
        const double edge = 2 * seen.radius * aside + (seen.high - seen.low) * along;
        const double voxels = std::ceil(edge / grid.spacing - 1e-6);
        if (!(voxels <= 16384))
            throw InvalidArgument("the detector sees " + std::to_string(voxels) + " voxels along axis " +
                                  std::to_string(axis) + "; name the size of the grid and its spacing");
        grid.dims[axis] = std::max(1, int(voxels));
    }
    return grid;
}

}  // namespace raysweep
