#include "raysweep/projector/joseph.h"

#include "raysweep/sweep/axis.h"

#include <algorithm>
#include <utility>

namespace raysweep {
namespace {

/// Sine of the angle below which two directions count as the same: over a thousand voxels they part by less than a
/// thousandth of one.
constexpr double kParallel = 1e-6;

Vec3 toVoxel(const ColumnLattice& lattice, const Matrix3& voxelFromWorld, const Vec3& point) {
    return (point - lattice.origin) * voxelFromWorld;
}

/// What the columns of a detector, relative to its rows, must follow an axis better by to be taken for rows.
constexpr double kOnSide = 1.001;

/// Makes rows of the detector's columns, if these run along the volume's better.
void turnIfOnSide(JosephView& view) {
    const Vec3 &column = view.xray.column, &row = view.xray.row;
    if (std::abs(column.z) * row.length() <= kOnSide * std::abs(row.z) * column.length()) return;
    view.onSide = true;
    std::swap(view.xray.column, view.xray.row);
    std::swap(view.width, view.height);
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

/// A detector column that leans, and whether its rays and rows allow to take it as one: they run across the same
/// slices, its rows ascend, and it leans less than it rises.
struct RolledCandidate {
    RolledColumn column;
    bool fits = false;
    bool forward = true;  ///< along the major axis
};

RolledCandidate rolledColumn(const JosephView& view, const Index3& dims, int number) {
    const int last = view.height - 1;
    const PixelRay ray = pixelRay(view, number, 0), middle = pixelRay(view, number, 0.5 * last);
    const bool cone = view.beam == BeamShape::cone;
    const Vec3 row = view.xray.row, perRow = cone ? row : Vec3(0), point = ray.point;
    RolledCandidate candidate;
    RolledColumn& column = candidate.column;
    const int axis = std::abs(middle.direction.x) >= std::abs(middle.direction.y) ? 0 : 1, lateral = 1 - axis;
    column.axis = axis;
    const Vec3& d = ray.direction;
    if (cone) {
        column.c = d[axis];
        column.d = row[axis];
        column.a0 = point.z * d[axis] - point[axis] * d.z;
        column.a1 = d.z;
        column.b0 = point.z * row[axis] - point[axis] * row.z;
        column.b1 = row.z;
    } else {
        const double slope = d.z / d[axis];
        column.a0 = point.z - point[axis] * slope;
        column.a1 = slope;
        column.b0 = row.z - row[axis] * slope;
    }
    const Vec3 normal = d.cross(row);  // of the plane in which the rays lie
    column.offset0 = normal.dot(point) / normal[lateral];
    column.offset1 = -normal[axis] / normal[lateral];
    column.lean = -normal.z / normal[lateral];
    const Vec3 first = d * view.worldFromVoxel, step = perRow * view.worldFromVoxel;
    const double scale = cone ? 1 : 1 / std::abs(d[axis]);
    column.length0 = first.dot(first) * scale * scale;
    column.length1 = 2 * first.dot(step);
    column.length2 = step.dot(step);
    column.slices = cone ? slicesAhead(point[axis], d[axis], dims[axis]) : IndexRange{0, dims[axis]};
    candidate.forward = d[axis] > 0;

    constexpr double kLeastMajor = 0.7, kMostLean = 1.2;
    const auto isMajor = [&](double v) {
        const Vec3 r = d + perRow * v;
        return r[axis] * middle.direction[axis] > 0 && std::abs(r[axis]) >= kLeastMajor * std::abs(r[lateral]);
    };
    candidate.fits = isMajor(0) && isMajor(last) && std::abs(column.lean) <= kMostLean;  // false also if infinite
    return candidate;
}

/// True if rows are nowhere in the volume so near to each other that a voxel has many of them beside it.
bool arePitchesWide(const RolledColumn& column, int rowCount) {
    constexpr float kLeast = 1.0f / 12;  // voxels
    if (column.slices.first >= column.slices.last) return true;
    for (const int slice : {column.slices.first, column.slices.last - 1})
        for (const float row : {0.0f, float(rowCount - 1)})
            if (!(column.rows(slice).pitch(row) > kLeast)) return false;
    return true;
}

/// Makes the view a rolled one, if all its detector columns can be taken so.
void addRolledColumns(JosephView& view, const Index3& dims) {
    bool ahead = true;
    std::vector<RolledColumn> columns;
    std::vector<DetectorColumnRun> runs;
    for (int number = 0; number < view.width; ++number) {
        const auto [column, fits, forward] = rolledColumn(view, dims, number);
        if (!fits || !arePitchesWide(column, view.height)) return;
        if (runs.empty() || runs.back().axis != column.axis || forward != ahead)
            runs.push_back({{number, number + 1}, column.axis});
        else
            runs.back().columns.last = number + 1;
        ahead = forward;
        columns.push_back(column);
    }
    view.kind = JosephView::Kind::rolled;
    view.rolled = std::move(columns);
    view.runs = std::move(runs);
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
    turnIfOnSide(view);
    if (view.xray.row.z < 0) {
        view.flipped = true;
        view.xray.origin += view.xray.row * (view.height - 1);
        view.xray.row = -view.xray.row;
    }
    if (isSteep(view)) return view;
    if (!alongColumns(view.xray.row)) {
        addRolledColumns(view, lattice.dims);
        return view;
    }
    const bool level =
        view.beam == BeamShape::parallel && std::abs(view.xray.direction.z) <= kParallel * view.xray.direction.length();
    view.kind = level ? JosephView::Kind::level : JosephView::Kind::upright;
    if (level) view.xray.direction.z = 0;
    addColumns(view, lattice.dims);
    return view;
}

int columnAxisFor(const ProjectionGeometry& geometry, const openvdb::math::Transform& transform) {
    const auto inIndexSpace = [&](const Vec3& step) {
        return transform.baseMap()->applyInverseJacobian(openvdb::Vec3d(step.x, step.y, step.z)).unit();
    };
    Vec3 along(0);
    for (const XrayView& view : geometry.views) {
        const openvdb::Vec3d row = inIndexSpace(view.row), column = inIndexSpace(view.column) / kOnSide;
        for (int axis = 0; axis < 3; ++axis) along[axis] += std::max(std::abs(row[axis]), std::abs(column[axis]));
    }
    return along.z >= std::max(along.x, along.y) ? 2 : majorAxis(along);
}

RayLine rayLine(const JosephView& view, const Index3& dims, int column, int row) {
    RayLine line;
    const PixelRay ray = pixelRay(view, column, row);
    // Near half a right angle a rolled detector column's rays follow the one in its middle.
    line.axis = view.rolled.empty() ? majorAxis(ray.direction) : view.rolled[std::size_t(column)].axis;
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
