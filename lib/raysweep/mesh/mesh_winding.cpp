#include "raysweep/mesh/mesh_winding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace raysweep {
namespace {

using openvdb::Vec3s;

/// Seen along z.
bool isBefore(const Vec3s& a, const Vec3s& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
}

/// Twice the area of (a, b, p) seen along z: above 0 if p lies to the left of the way from a to b. Rounded the same
/// whichever of them is named first, so that triangles that share an edge agree on which side of it p is.
double side(const Vec3s& a, const Vec3s& b, double x, double y) {
    if (isBefore(b, a)) return -side(b, a, x, y);
    return (double(b.x()) - double(a.x())) * (y - double(a.y())) -
           (double(b.y()) - double(a.y())) * (x - double(a.x()));
}

/// A place on an edge belongs to one of the two sides.
bool isLeft(const Vec3s& a, const Vec3s& b, double side) {
    return side > 0 || (side == 0 && isBefore(a, b));
}

/// Where the rays of one x may meet a triangle. A little more than that: `side` decides.
struct Column {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

    /// Takes in where the edge from `a` to `b` is at `x`.
    void add(const Vec3s& a, const Vec3s& b, double x) {
        const double left = double(a.x()), right = double(b.x());
        if (x < std::min(left, right) || x > std::max(left, right)) return;
        if (left == right) return take(double(a.y())), take(double(b.y()));
        take(double(a.y()) + (double(b.y()) - double(a.y())) * ((x - left) / (right - left)));
    }

    int first() const { return int(std::ceil(low - kRounding)); }
    int last() const { return int(std::floor(high + kRounding)); }

  private:
    static constexpr double kRounding = 1e-3;  ///< of doubles at places up to 65536: 1e-10 at most

    void take(double y) {
        low = std::min(low, y);
        high = std::max(high, y);
    }
};

}  // namespace

MeshWinding::MeshWinding(const MeshPart& part, const MeshLattice& lattice) {
    const std::vector<Vec3s> points = latticePoints(part.mesh, lattice);
    for (const std::uint32_t i : part.triangles) {
        const TriangleMesh::Triangle& t = part.mesh.triangles[i];
        add({points[t[0]], points[t[1]], points[t[2]]});
    }
    std::sort(crossings_.begin(), crossings_.end(), isBefore);
}

void MeshWinding::add(const Vec3s (&corners)[3]) {
    Vec3s a = corners[0], b = corners[1], c = corners[2];
    const double area = side(a, b, double(c.x()), double(c.y()));
    if (area == 0) return;
    if (area < 0) std::swap(b, c);       // counter-clockwise seen from above
    const int sign = area > 0 ? -1 : 1;  // a face that looks along z is left
    const auto first = int(std::ceil(std::min({a.x(), b.x(), c.x()})));
    const auto last = int(std::floor(std::max({a.x(), b.x(), c.x()})));
    for (int x = first; x <= last; ++x) {
        Column column;
        column.add(a, b, x);
        column.add(b, c, x);
        column.add(c, a, x);
        for (int y = column.first(); y <= column.last(); ++y) {
            const double atC = side(a, b, x, y), atA = side(b, c, x, y), atB = side(c, a, x, y);
            if (!isLeft(a, b, atC) || !isLeft(b, c, atA) || !isLeft(c, a, atB)) continue;
            const double z = (atA * double(a.z()) + atB * double(b.z()) + atC * double(c.z())) / (atA + atB + atC);
            crossings_.push_back({x, y, float(z), sign});
        }
    }
}

bool MeshWinding::isBefore(const Crossing& a, const Crossing& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z != b.z ? a.z < b.z : a.sign < b.sign;
}

int MeshWinding::numberAt(const openvdb::Coord& voxel) const {
    int number = 0;
    const Crossing start{voxel.x(), voxel.y(), -std::numeric_limits<float>::infinity(), -1};
    auto crossing = std::lower_bound(crossings_.begin(), crossings_.end(), start, isBefore);
    for (; crossing != crossings_.end() && crossing->x == voxel.x() && crossing->y == voxel.y() &&
           crossing->z < float(voxel.z());
         ++crossing)
        number += crossing->sign;
    return number;
}

}  // namespace raysweep
