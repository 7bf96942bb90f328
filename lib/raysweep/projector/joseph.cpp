#include "raysweep/projector/joseph.h"

#include "raysweep/sweep/axis.h"

#include <algorithm>

namespace raysweep {
namespace {

/// Sine of the angle below which two directions count as the same: over a thousand voxels they part by less than a
/// thousandth of one.
constexpr double kParallel = 1e-6;

Vec3 toVoxel(const ColumnLattice& lattice, const Matrix3& voxelFromWorld, const Vec3& point) {
    return (point - lattice.origin) * voxelFromWorld;
}

bool alongColumns(const Vec3& v) {
    return std::hypot(v.x, v.y) <= kParallel * std::abs(v.z);
}

/// Slices in (low, high) that lie in [0, count), low and high in any order and maybe infinite.
IndexRange slicesBetween(double low, double high, int count) {
    if (low > high) std::swap(low, high);
    const double first = std::max(0.0, std::floor(low) + 1), last = std::min(double(count), std::ceil(high));
    return first < last ? IndexRange{int(first), int(last)} : IndexRange{};
}

IndexRange common(const IndexRange& a, const IndexRange& b) {
    const IndexRange both{std::max(a.first, b.first), std::min(a.last, b.last)};
    return both.first < both.last ? both : IndexRange{};
}

constexpr double kInfinity = 1e30;

/// Slices in which a line has a voxel of [0, count) beside it.
IndexRange slicesBeside(double lateral0, double lateral1, int count, int slices) {
    if (lateral1 == 0) return lateral0 > -1 && lateral0 < count ? IndexRange{0, slices} : IndexRange{};
    return slicesBetween((-1 - lateral0) / lateral1, (count - lateral0) / lateral1, slices);
}

/// Slices before the source, seen from which the ray runs along `direction`.
IndexRange slicesAhead(double source, double direction, int slices) {
    return slicesBetween(source, direction > 0 ? kInfinity : -kInfinity, slices);
}

/// A point that the ray of a pixel passes, and its direction; seen from the source for a cone.
struct PixelRay {
    Vec3 point, direction;
};

PixelRay pixelRay(const JosephView& view, double column, double row) {
    if (view.beam == BeamShape::parallel) return {view.xray.pixel(column, row), view.xray.direction};
    return {view.xray.source, view.xray.pixel(column, row) - view.xray.source};
}

DetectorColumn detectorColumn(const JosephView& view, const Index3& dims, int column) {
    DetectorColumn line;
    line.rowCount = view.height;
    const PixelRay ray = pixelRay(view, column, 0);
    const int axis = std::abs(ray.direction.x) >= std::abs(ray.direction.y) ? 0 : 1, lateral = 1 - axis;
    line.axis = axis;
    const double major = ray.direction[axis];
    line.lateral1 = ray.direction[lateral] / major;
    line.lateral0 = ray.point[lateral] - line.lateral1 * ray.point[axis];
    line.height1 = ray.direction.z / major;
    line.height0 = ray.point.z - line.height1 * ray.point[axis];
    Vec3 perRow(0);  // what a row adds to the direction
    if (view.beam == BeamShape::parallel) {
        line.pitch0 = view.xray.row.z;
    } else {
        line.pitch1 = view.xray.row.z / major;
        line.pitch0 = -line.pitch1 * ray.point[axis];
        perRow = view.xray.row * view.worldFromVoxel / major;
    }
    const Vec3 perSlice = ray.direction * view.worldFromVoxel / major;
    line.length0 = perSlice.dot(perSlice);
    line.length1 = 2 * perSlice.dot(perRow);
    line.length2 = perRow.dot(perRow);
    line.slices = slicesBeside(line.lateral0, line.lateral1, dims[lateral], dims[axis]);
    if (view.beam == BeamShape::cone)
        line.slices = common(line.slices, slicesAhead(ray.point[axis], major, dims[axis]));
    return line;
}

/// True if a ray is nearer to z than to x and y: then slices of x or y are too far apart for it.
bool isSteep(const JosephView& view) {
    for (int column = 0; column < view.width; ++column)  // of a row, z is extreme at an end; x and y need not be
        for (const int row : {0, view.height - 1}) {
            const Vec3 d = pixelRay(view, column, row).direction;
            if (std::abs(d.z) > std::max(std::abs(d.x), std::abs(d.y))) return true;
        }
    return false;
}

void addColumns(JosephView& view, const Index3& dims) {
    view.columns.reserve(std::size_t(view.width));
    bool ahead = true;
    for (int column = 0; column < view.width; ++column) {
        view.columns.push_back(detectorColumn(view, dims, column));
        const int axis = view.columns.back().axis;
        const bool forward = pixelRay(view, column, 0).direction[axis] > 0;
        if (view.runs.empty() || view.runs.back().axis != axis || forward != ahead)
            view.runs.push_back({{column, column + 1}, axis});
        else
            view.runs.back().columns.last = column + 1;
        ahead = forward;
    }
}

}  // namespace

JosephView josephView(const ProjectionGeometry& geometry, int number, const ColumnLattice& lattice) {
    JosephView view;
    view.beam = geometry.beam;
    view.width = geometry.width;
    view.height = geometry.height;
    view.worldFromVoxel = lattice.worldFromVoxel;
    const Matrix3 voxelFromWorld = lattice.worldFromVoxel.inverse();
    const XrayView& world = geometry.views[std::size_t(number)];
    view.xray.source = toVoxel(lattice, voxelFromWorld, world.source);
    view.xray.origin = toVoxel(lattice, voxelFromWorld, world.origin);
    view.xray.direction = world.direction * voxelFromWorld;
    view.xray.column = world.column * voxelFromWorld;
    view.xray.row = world.row * voxelFromWorld;
    if (view.xray.row.z < 0) {
        view.flipped = true;
        view.xray.origin += view.xray.row * (view.height - 1);
        view.xray.row = -view.xray.row;
    }
    if (!alongColumns(view.xray.row) || isSteep(view)) return view;
    const bool level =
        view.beam == BeamShape::parallel && std::abs(view.xray.direction.z) <= kParallel * view.xray.direction.length();
    view.kind = level ? JosephView::Kind::level : JosephView::Kind::upright;
    if (level) view.xray.direction.z = 0;
    addColumns(view, lattice.dims);
    return view;
}

int columnAxisFor(const ProjectionGeometry& geometry, const openvdb::math::Transform& transform) {
    Vec3 along(0);
    for (const XrayView& view : geometry.views) {
        const auto index =
            transform.baseMap()->applyInverseJacobian(openvdb::Vec3d(view.row.x, view.row.y, view.row.z));
        const double length = index.length();
        for (int axis = 0; axis < 3; ++axis) along[axis] += std::abs(index[axis]) / length;
    }
    return along.z >= std::max(along.x, along.y) ? 2 : majorAxis(along);
}

RayLine rayLine(const JosephView& view, const Index3& dims, int column, int row) {
    RayLine line;
    const PixelRay ray = pixelRay(view, column, row);
    line.axis = majorAxis(ray.direction);
    const double major = ray.direction[line.axis];
    const int others[2] = {line.axis == 0 ? 1 : 0, line.axis == 2 ? 1 : 2};
    line.length = float((ray.direction * view.worldFromVoxel / major).length());
    line.slices = IndexRange{0, dims[line.axis]};
    for (int i = 0; i < 2; ++i) {
        line.lateral1[i] = ray.direction[others[i]] / major;
        line.lateral0[i] = ray.point[others[i]] - line.lateral1[i] * ray.point[line.axis];
        line.slices =
            common(line.slices, slicesBeside(line.lateral0[i], line.lateral1[i], dims[others[i]], dims[line.axis]));
    }
    if (view.beam == BeamShape::cone)
        line.slices = common(line.slices, slicesAhead(ray.point[line.axis], major, dims[line.axis]));
    return line;
}

}  // namespace raysweep
