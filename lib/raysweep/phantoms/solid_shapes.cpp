#include "raysweep/phantoms/solid_shapes.h"

#include "raysweep/core/require.h"
#include "raysweep/phantoms/leaf_fill.h"

#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace raysweep {
namespace {

using Kind = SolidShape::Kind;

/// A vector in units of the shape's half axes.
Vec3 inHalfAxes(const SolidShape& shape, const Vec3& v) {
    const auto along = [&](const Vec3& axis) { return v.dot(axis) / axis.length2(); };
    return Vec3(along(shape.halfAxes[0]), along(shape.halfAxes[1]), along(shape.halfAxes[2]));
}

struct Interval {
    double from, to;  ///< empty unless from < to

    void cut(double low, double high) {
        from = std::max(from, low);
        to = std::min(to, high);
    }
};

/// Cuts to where |o + t d| <= 1 along one axis.
void cutSlab(Interval& range, double o, double d) {
    if (d == 0) {
        if (std::abs(o) > 1) range.to = range.from;
        return;
    }
    const double a = (-1 - o) / d, b = (1 - o) / d;
    range.cut(std::min(a, b), std::max(a, b));
}

/// Cuts to where a t² + 2 b t + c <= 0: inside of a unit ball or circle.
void cutRound(Interval& range, double a, double b, double c) {
    if (a == 0) {
        if (c > 0) range.to = range.from;
        return;
    }
    const double discriminant = b * b - a * c;
    if (discriminant <= 0) {
        range.to = range.from;
        return;
    }
    const double root = std::sqrt(discriminant);
    range.cut((-b - root) / a, (-b + root) / a);
}

/// Length of the part of the line, within `range`, that is in the shape.
double chord(const SolidShape& shape, const Vec3& origin, const Vec3& direction, Interval range) {
    // Relative to the point of the line that is nearest to the centre: a far source would cost digits.
    const Vec3 toCenter = shape.center - origin;
    const double nearest = toCenter.dot(direction);
    range = {range.from - nearest, range.to - nearest};
    const Vec3 o = inHalfAxes(shape, direction * nearest - toCenter), d = inHalfAxes(shape, direction);
    switch (shape.kind) {
        case Kind::ellipsoid:
            cutRound(range, d.length2(), o.dot(d), o.length2() - 1);
            break;
        case Kind::box:
            for (int axis = 0; axis < 3; ++axis) cutSlab(range, o[axis], d[axis]);
            break;
        case Kind::cylinder:
            cutRound(range, d.x * d.x + d.y * d.y, o.x * d.x + o.y * d.y, o.x * o.x + o.y * o.y - 1);
            cutSlab(range, o.z, d.z);
            break;
    }
    return std::max(0.0, range.to - range.from);
}

bool isInside(const SolidShape& shape, const Vec3& point) {
    const Vec3 p = inHalfAxes(shape, point - shape.center);
    switch (shape.kind) {
        case Kind::ellipsoid:
            return p.length2() <= 1;
        case Kind::box:
            return std::abs(p.x) <= 1 && std::abs(p.y) <= 1 && std::abs(p.z) <= 1;
        case Kind::cylinder:
            return p.x * p.x + p.y * p.y <= 1 && std::abs(p.z) <= 1;
    }
    return false;
}

enum class Overlap { none, partial, full };

/// How much of the ball about `center` is in the shape; `partial` where that is not easily said.
Overlap overlapOf(const SolidShape& shape, const Vec3& center, double radius) {
    const Vec3 p = inHalfAxes(shape, center - shape.center);
    const Vec3 reach(radius / shape.halfAxes[0].length(), radius / shape.halfAxes[1].length(),
                     radius / shape.halfAxes[2].length());
    bool none = false, full = true;
    const auto demand = [&](double distance, double slack) {
        none = none || distance - slack > 1;
        full = full && distance + slack <= 1;
    };
    switch (shape.kind) {
        case Kind::ellipsoid:
            demand(p.length(), std::max({reach.x, reach.y, reach.z}));
            break;
        case Kind::box:
            for (int axis = 0; axis < 3; ++axis) demand(std::abs(p[axis]), reach[axis]);
            break;
        case Kind::cylinder:
            demand(std::hypot(p.x, p.y), std::max(reach.x, reach.y));
            demand(std::abs(p.z), reach.z);
            break;
    }
    return none ? Overlap::none : full ? Overlap::full : Overlap::partial;
}

/// What matters within a ball: the density that all of it has, and the shapes whose surface may cross it.
struct Neighborhood {
    double common = 0;
    std::vector<SolidShape> crossing;
};

void lookAround(const std::vector<SolidShape>& shapes, const Vec3& center, double radius, Neighborhood& found) {
    found.crossing.clear();
    for (const SolidShape& shape : shapes) {
        const Overlap overlap = overlapOf(shape, center, radius);
        if (overlap == Overlap::full) found.common += shape.density;
        if (overlap == Overlap::partial) found.crossing.push_back(shape);
    }
}

constexpr int kLines = 8;  ///< across a voxel

/// Mean density in the cube of edge h: line integrals along z are exact, and taken on a raster.
double meanInCube(const std::vector<SolidShape>& shapes, const Vec3& center, double h) {
    double sum = 0;
    for (int a = 0; a < kLines; ++a)
        for (int b = 0; b < kLines; ++b) {
            const Vec3 offset((a + 0.5) / kLines - 0.5, (b + 0.5) / kLines - 0.5, 0);
            sum += lineIntegral(shapes, center + offset * h, Vec3(0, 0, 1), -0.5 * h, 0.5 * h);
        }
    return sum / (h * kLines * kLines);
}

SolidShape alongAxes(Kind kind, double density, const Vec3& center, const Vec3& halfAxes) {
    SolidShape shape;
    shape.kind = kind;
    shape.density = density;
    shape.center = center;
    for (int axis = 0; axis < 3; ++axis) shape.halfAxes[axis] *= halfAxes[axis];
    return shape;
}

}  // namespace

SolidShape ellipsoid(double density, const Vec3& center, const Vec3& halfAxes, double degrees) {
    SolidShape shape = alongAxes(Kind::ellipsoid, density, center, halfAxes);
    const double c = std::cos(degrees * kPi / 180), s = std::sin(degrees * kPi / 180);
    for (Vec3& axis : shape.halfAxes) axis = Vec3(c * axis.x - s * axis.y, s * axis.x + c * axis.y, axis.z);
    return shape;
}

SolidShape box(double density, const Vec3& center, const Vec3& halfEdges) {
    return alongAxes(Kind::box, density, center, halfEdges);
}

SolidShape cylinder(double density, const Vec3& center, int axis, double radius, double halfLength) {
    SolidShape shape = alongAxes(Kind::cylinder, density, center, Vec3(radius));
    shape.halfAxes[axis] *= halfLength / radius;
    std::swap(shape.halfAxes[axis], shape.halfAxes[2]);
    return shape;
}

double densityAt(const std::vector<SolidShape>& shapes, const Vec3& point) {
    double density = 0;
    for (const SolidShape& shape : shapes)
        if (isInside(shape, point)) density += shape.density;
    return density;
}

double lineIntegral(const std::vector<SolidShape>& shapes, const Vec3& origin, const Vec3& direction, double from,
                    double to) {
    double sum = 0;
    for (const SolidShape& shape : shapes) sum += shape.density * chord(shape, origin, direction, {from, to});
    return sum;
}

openvdb::FloatGrid::Ptr voxelize(const std::vector<SolidShape>& shapes, const openvdb::Coord& dims, double voxelSize) {
    for (int axis = 0; axis < 3; ++axis)
        requireField(dims[axis] >= 1, "dims[" + std::to_string(axis) + "]", dims[axis], "at least 1");
    requireField(voxelSize > 0 && std::isfinite(voxelSize), "voxelSize", voxelSize, "positive and finite");
    const double h = voxelSize;
    const Vec3 middle = Vec3(dims.x() - 1, dims.y() - 1, dims.z() - 1) * 0.5;
    const auto grid = openvdb::FloatGrid::create(0.0f);
    const auto transform = openvdb::math::Transform::createLinearTransform(h);
    transform->postTranslate(openvdb::Vec3d(middle.x, middle.y, middle.z) * -h);
    grid->setTransform(transform);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);

    double largest = 0;
    for (const SolidShape& shape : shapes) largest = std::max(largest, std::abs(shape.density));
    const double voxelRadius = 0.5 * std::sqrt(3.0) * h;
    const auto nearLeaf = [&](const Vec3& center, Neighborhood& leaf) {
        lookAround(shapes, center * h, kLeafRadius * h + voxelRadius, leaf);
        return leaf.common != 0 || !leaf.crossing.empty();
    };
    const auto mean = [&](const Vec3& position, const Neighborhood& leaf) {
        Neighborhood voxel;
        voxel.common = leaf.common;
        if (!leaf.crossing.empty()) lookAround(leaf.crossing, position * h, voxelRadius, voxel);
        double value = voxel.common;
        if (!voxel.crossing.empty()) value += meanInCube(voxel.crossing, position * h, h);
        // Densities that cancel leave rounding errors, which are not worth a voxel.
        return value > 1e-9 * largest ? value : 0.0;
    };
    fillLeaves<Neighborhood>(*grid, {openvdb::CoordBBox(openvdb::Coord(0), dims.offsetBy(-1)), middle}, nearLeaf, mean);
    openvdb::tools::prune(grid->tree());
    return grid;
}

}  // namespace raysweep
