#include "raysweep/reconstruct/reconstruction_grid.h"

#include "raysweep/core/error.h"
#include "raysweep/core/require.h"
#include "raysweep/reconstruct/orbit_fit.h"
#include "raysweep/volume/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
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

/// Nothing if the views are not those of a turn.
std::optional<OrbitFit> orbitOf(const ProjectionGeometry& geometry) {
    try {
        return fitOrbit(geometry);
    } catch (const InvalidArgument&) {
        return {};
    }
}

/// The middle of what a turn's detector sees.
Vec3 seenMiddle(const Seen& seen, const OrbitFit& orbit) {
    return orbit.center + orbit.axis * (0.5 * (seen.low + seen.high));
}

/// The point that the rays through the detector's middle come closest to, in the sense of least squares; if they are
/// all parallel, the one of those that is closest to the origin.
Vec3 middleRaysMeet(const ProjectionGeometry& geometry) {
    constexpr double kRidge = 1e-9;
    Matrix3 normal(0.0);
    Vec3 right(0);
    for (const XrayView& view : geometry.views) {
        const Vec3 middle = view.pixel(0.5 * (geometry.width - 1), 0.5 * (geometry.height - 1));
        const Vec3 ray = (geometry.beam == BeamShape::cone ? middle - view.source : view.direction).normalized();
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) normal[a][b] += (a == b ? 1 + kRidge : 0) - ray[a] * ray[b];
        right += middle - ray * middle.dot(ray);
    }
    return right * normal.inverse();
}

/// @param spacing the middle is a multiple of a millionth of it, so that a fit's rounding does not show
Vec3 middleSeen(const ProjectionGeometry& geometry, double spacing) {
    const std::optional<OrbitFit> orbit = orbitOf(geometry);
    Vec3 middle = orbit ? seenMiddle(seenOf(geometry, *orbit), *orbit) : middleRaysMeet(geometry);
    const double unit = 1e-6 * spacing;
    for (int axis = 0; axis < 3; ++axis) middle[axis] = std::round(middle[axis] / unit) * unit;
    return middle;
}

/// All that the detector sees, which nobody can know if it does not turn.
ReconstructionGrid turnedGrid(const ProjectionGeometry& geometry) {
    if (!orbitOf(geometry))
        throw InvalidArgument("the views are not those of a turn about an axis that is seen", Remedy::giveGrid);
    return coveringGrid(geometry);
}

/// The middle of `grid`, moved by less than a voxel to where its voxels are those of `frame`.
Vec3 snapped(const ReconstructionGrid& grid, const openvdb::FloatGrid& frame) {
    const Vec3 first = grid.voxel(0, 0, 0);
    const openvdb::Coord nearest = openvdb::Coord::round(frame.worldToIndex(openvdb::Vec3d(first.x, first.y, first.z)));
    const openvdb::Vec3d place = frame.indexToWorld(nearest);
    return grid.center + Vec3(place.x(), place.y(), place.z()) - first;
}

/// True if the axes of a volume's voxels are the world's.
bool isUpright(const openvdb::FloatGrid& volume) {
    constexpr double kSame = 1e-4;  // relative
    const openvdb::Vec3d edges = volume.voxelSize(), origin = volume.indexToWorld(openvdb::Vec3d(0.0));
    for (int axis = 0; axis < 3; ++axis) {
        openvdb::Vec3d step(0.0);
        step[axis] = 1;
        if (!(volume.indexToWorld(step)[axis] - origin[axis] > (1 - kSame * kSame) * edges[axis])) return false;
    }
    return true;
}

/// Edges of the voxels of a volume that says where to reconstruct. Those that do not lie along the world's axes must be
/// cubes.
Vec3 edgesOf(const openvdb::FloatGrid& frame) {
    constexpr double kSame = 1e-4;  // relative
    const openvdb::Vec3d edges = frame.voxelSize();
    if (edges[openvdb::math::MaxIndex(edges)] <= (1 + kSame) * edges[openvdb::math::MinIndex(edges)])
        return Vec3(edges[0]);
    return isUpright(frame) ? Vec3(edges[0], edges[1], edges[2]) : Vec3(0);
}

void requireEdges(const Vec3& edges) {
    if (edges.x > 0) return;
    throw InvalidArgument(
        "the voxels of the initial or reference volume are no cubes and do not lie along the world's axes, so they do "
        "not say where to reconstruct",
        Remedy::giveGrid);
}

/// @param asked what of the grid is not the frame's
ReconstructionGrid gridOf(const openvdb::FloatGrid& frame, const GridOptions& asked) {
    const Vec3 edges = edgesOf(frame);
    if (!asked.dims || !asked.spacing) requireEdges(edges);
    const openvdb::Coord dims = frame.evalActiveVoxelBoundingBox().dim();
    return {Index3(dims.x(), dims.y(), dims.z()), middleOf(frame), edges};
}

}  // namespace

openvdb::math::Transform::Ptr ReconstructionGrid::transform() const {
    using openvdb::math::Transform;
    const auto transform = hasCubes() ? Transform::createLinearTransform(edge())
                                      : std::make_shared<Transform>(std::make_shared<openvdb::math::ScaleMap>(
                                            openvdb::Vec3d(spacing.x, spacing.y, spacing.z)));
    const Vec3 first = voxel(0, 0, 0);
    transform->postTranslate(openvdb::Vec3d(first.x, first.y, first.z));
    return transform;
}

void ReconstructionGrid::validate() const {
    for (int axis = 0; axis < 3; ++axis) {
        const std::string number = "[" + std::to_string(axis) + "]";
        requireField(dims[axis] >= 1, "reconstruction grid dims" + number, dims[axis], "at least 1");
        requireField(std::isfinite(center[axis]), "reconstruction grid center" + number, center[axis], "finite");
        requireField(spacing[axis] > 0 && std::isfinite(spacing[axis]), "reconstruction grid spacing" + number,
                     spacing[axis], "positive and finite");
    }
}

void ReconstructionGrid::requireCubes() const {
    if (hasCubes()) return;
    std::ostringstream message;
    message << "reconstruction grid spacing " << spacing << ": edges must be the same";
    throw InvalidArgument(message.str());
}

std::optional<double> edgeOfCubes(const openvdb::math::Transform& transform) {
    if (!transform.isLinear()) return {};
    const double edge = transform.voxelSize().x();
    const openvdb::Vec3d origin = transform.indexToWorld(openvdb::Vec3d(0.0));
    for (int axis = 0; axis < 3; ++axis) {
        openvdb::Vec3d step(0.0);
        step[axis] = 1;
        openvdb::Vec3d beside = transform.indexToWorld(step) - origin;
        beside[axis] -= edge;
        if (beside.length() > 1e-6 * edge) return {};
    }
    return edge;
}

ReconstructionGrid coveringGrid(const ProjectionGeometry& geometry) {
    const OrbitFit orbit = fitOrbit(geometry);
    const Seen seen = seenOf(geometry, orbit);
    ReconstructionGrid grid;
    grid.spacing = Vec3(seen.pixel);
    grid.center = seenMiddle(seen, orbit);
    for (int axis = 0; axis < 3; ++axis) {
        // The box about an upright or tilted cylinder.
        const double along = std::abs(orbit.axis[axis]), aside = std::sqrt(std::max(0.0, 1 - along * along));
        const double edge = 2 * seen.radius * aside + (seen.high - seen.low) * along;
        const double voxels = std::ceil(edge / seen.pixel - 1e-6);
        if (!(voxels <= kMostVoxelsAlong))
            throw InvalidArgument("the detector sees " + std::to_string(voxels) + " voxels along axis " +
                                  std::to_string(axis) + "; name the size of the grid and its spacing");
        grid.dims[axis] = std::max(1, int(voxels));
    }
    return grid;
}

void GridOptions::validate() const {
    for (int axis = 0; dims && axis < 3; ++axis) {
        const int voxels = (*dims)[axis];
        requireField(voxels >= 1 && voxels <= kMostVoxelsAlong, "dims[" + std::to_string(axis) + "]", voxels,
                     "1 to " + std::to_string(kMostVoxelsAlong));
    }
    for (int axis = 0; center && axis < 3; ++axis)
        requireField(std::isfinite((*center)[axis]), "center[" + std::to_string(axis) + "]", (*center)[axis], "finite");
    for (int axis = 0; spacing && axis < 3; ++axis)
        requireField((*spacing)[axis] > 0 && std::isfinite((*spacing)[axis]), "spacing", (*spacing)[axis],
                     "positive and finite");
}

ReconstructionGrid reconstructionGrid(const ProjectionGeometry& geometry, const GridOptions& options,
                                      const openvdb::FloatGrid* frame) {
    options.validate();
    ReconstructionGrid grid;
    if (frame)
        grid = gridOf(*frame, options);
    else if (!options.dims || !options.spacing)
        grid = turnedGrid(geometry);
    const Vec3 extent = grid.size();
    if (options.spacing) grid.spacing = *options.spacing;
    if (options.dims) {
        grid.dims = *options.dims;
    } else if (options.spacing) {
        for (int axis = 0; axis < 3; ++axis)
            grid.dims[axis] =
                int(std::clamp(std::round(extent[axis] / grid.spacing[axis]), 1.0, double(kMostVoxelsAlong)));
    }
    if (options.center)
        grid.center = *options.center;
    else if (frame)
        grid.center = snapped(grid, *frame);
    else if (options.dims && options.spacing)
        grid.center = middleSeen(geometry, grid.shortestEdge());
    return grid;
}

}  // namespace raysweep
