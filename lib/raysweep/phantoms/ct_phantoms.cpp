#include "raysweep/phantoms/ct_phantoms.h"

#include <algorithm>

namespace raysweep {
namespace {

struct HeadEllipsoid {
    Vec3 center, halfAxes;
    double degrees;  ///< about z
    double original, modified;
};

const HeadEllipsoid kHead[] = {
    {{0, 0, 0}, {0.69, 0.92, 0.9}, 0, 2, 1},
    {{0, 0, 0}, {0.6624, 0.874, 0.88}, 0, -0.98, -0.8},
    {{-0.22, 0, -0.25}, {0.41, 0.16, 0.21}, 108, -0.02, -0.2},
    {{0.22, 0, -0.25}, {0.31, 0.11, 0.22}, 72, -0.02, -0.2},
    {{0, 0.35, -0.25}, {0.21, 0.25, 0.5}, 0, 0.02, 0.2},
    {{0, 0.1, -0.25}, {0.046, 0.046, 0.046}, 0, 0.02, 0.2},
    {{-0.08, -0.65, -0.25}, {0.046, 0.023, 0.02}, 0, 0.01, 0.1},
    {{0.06, -0.65, -0.25}, {0.046, 0.023, 0.02}, 90, 0.01, 0.1},
    {{0.06, -0.105, 0.625}, {0.056, 0.04, 0.1}, 90, 0.02, 0.2},
    {{0, 0.1, 0.625}, {0.056, 0.056, 0.1}, 0, -0.02, -0.2},
};

/// Part of the extent that the box takes up.
constexpr double kBoxPart = 0.625;

/// The two coordinates, of the box's half edges, that a drilled hole runs through; the one along it is not used.
struct Drilled {
    int axis;
    Vec3 at;
    double radius;
};
struct Hollow {
    Vec3 at;
    double radius, density;
};

// No two meet: holes along z keep to y < -0.4, those along x to y > 0 and z < -0.2, those along y to x > 0.15 and
// z > 0.3, and hollows to what is left.
const Drilled kDrilled[] = {
    {2, {-0.60, -0.60, 0}, 0.20}, {2, {-0.20, -0.60, 0}, 0.12}, {2, {0.05, -0.60, 0}, 0.06},
    {0, {0, 0.30, -0.50}, 0.22},  {0, {0, 0.70, -0.60}, 0.10},  {1, {0.60, 0, 0.50}, 0.20},
    {1, {0.25, 0, 0.60}, 0.08},
};
const Hollow kHollows[] = {
    {{-0.50, 0.50, 0.45}, 0.30, -1},
    {{-0.10, 0.15, 0.60}, 0.15, -0.5},
    {{-0.65, -0.15, 0.60}, 0.08, -1},
    {{-0.30, 0.00, 0.00}, 0.05, -1},
};

openvdb::Coord dimsOf(const PhantomOptions& options) {
    return options.dims == openvdb::Coord(0, 0, 0) ? openvdb::Coord(options.size) : options.dims;
}

double voxelSizeOf(const PhantomOptions& options) {
    const openvdb::Coord dims = dimsOf(options);
    return options.voxelSize > 0 ? options.voxelSize : 2.0 / std::max({dims.x(), dims.y(), dims.z()});
}

std::vector<SolidShape> scaledDensity(std::vector<SolidShape> shapes, double factor) {
    for (SolidShape& shape : shapes) shape.density *= factor;
    return shapes;
}

}  // namespace

std::vector<SolidShape> sheppLogan(double halfSize, HeadContrast contrast) {
    std::vector<SolidShape> shapes;
    for (const HeadEllipsoid& e : kHead) {
        const double density = contrast == HeadContrast::original ? e.original : e.modified;
        shapes.push_back(ellipsoid(density, e.center * halfSize, e.halfAxes * halfSize, e.degrees));
    }
    return shapes;
}

std::vector<SolidShape> boxWithHoles(const Vec3& halfSize) {
    const Vec3 half = halfSize * kBoxPart;
    const double smallest = std::min({half.x, half.y, half.z});
    std::vector<SolidShape> shapes{box(1, Vec3(0), half)};
    for (const Drilled& hole : kDrilled)
        shapes.push_back(cylinder(-1, hole.at * half, hole.axis, hole.radius * smallest, half[hole.axis]));
    for (const Hollow& hole : kHollows)
        shapes.push_back(ellipsoid(hole.density, hole.at * half, Vec3(hole.radius * smallest)));
    return shapes;
}

std::vector<SolidShape> sheppLogan(const PhantomOptions& options) {
    options.validate();
    PhantomOptions cube = options;
    cube.dims = openvdb::Coord(0, 0, 0);
    return scaledDensity(sheppLogan(0.5 * cube.size * voxelSizeOf(cube)), options.density);
}

std::vector<SolidShape> boxWithHoles(const PhantomOptions& options) {
    options.validate();
    const openvdb::Coord dims = dimsOf(options);
    const Vec3 halfSize = Vec3(dims.x(), dims.y(), dims.z()) * (0.5 * voxelSizeOf(options));
    return scaledDensity(boxWithHoles(halfSize), options.density);
}

openvdb::FloatGrid::Ptr makeSheppLogan(const PhantomOptions& options) {
    PhantomOptions cube = options;
    cube.dims = openvdb::Coord(0, 0, 0);
    return voxelize(sheppLogan(options), dimsOf(cube), voxelSizeOf(cube));
}

openvdb::FloatGrid::Ptr makeBoxWithHoles(const PhantomOptions& options) {
    return voxelize(boxWithHoles(options), dimsOf(options), voxelSizeOf(options));
}

}  // namespace raysweep
