#include "raysweep/phantoms/convex_clip.h"

#include <algorithm>
#include <cmath>

namespace raysweep {
namespace {

using Polygon = std::vector<Vec3>;
using Polyhedron = std::vector<Polygon>;  // convex; the order of a face's corners does not matter to anyone

Polyhedron unitCube() {
    Polyhedron faces;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-0.5, 0.5}) {
            Polygon face;
            for (const auto& [u, v] : {std::pair(-0.5, -0.5), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
                Vec3 corner;
                corner[axis] = side, corner[(axis + 1) % 3] = u, corner[(axis + 2) % 3] = v;
                face.push_back(corner);
            }
            faces.push_back(face);
        }
    return faces;
}

/// Sutherland and Hodgman's step; points on the plane are added to `cut`.
Polygon clipped(const Polygon& face, const HalfSpace& space, Polygon& cut) {
    Polygon kept;
    for (std::size_t i = 0; i < face.size(); ++i) {
        const Vec3 &a = face[i], &b = face[(i + 1) % face.size()];
        const double da = space.normal.dot(a) - space.offset, db = space.normal.dot(b) - space.offset;
        if (da <= 0) kept.push_back(a);
        if ((da <= 0) == (db <= 0)) continue;
        kept.push_back(a + (b - a) * (da / (da - db)));
        cut.push_back(kept.back());
    }
    return kept;
}

/// The points of a convex face in the order around it.
void sortAround(Polygon& points, const Vec3& normal) {
    Vec3 middle(0);
    for (const Vec3& p : points) middle += p / double(points.size());
    Vec3 u = points.front() - middle;
    const Vec3 v = normal.cross(u);
    std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
        return std::atan2(v.dot(a - middle), u.dot(a - middle)) < std::atan2(v.dot(b - middle), u.dot(b - middle));
    });
}

Polyhedron clipped(const Polyhedron& faces, const HalfSpace& space) {
    Polyhedron result;
    Polygon cut;
    for (const Polygon& face : faces) {
        Polygon rest = clipped(face, space, cut);
        if (rest.size() > 2) result.push_back(std::move(rest));
    }
    if (cut.size() > 2) {
        sortAround(cut, space.normal);
        result.push_back(std::move(cut));
    }
    return result;
}

/// Pyramids over all faces, with a common tip inside.
double volumeOf(const Polyhedron& faces) {
    Vec3 tip(0);
    double corners = 0;
    for (const Polygon& face : faces)
        for (const Vec3& p : face) tip += p, corners += 1;
    if (corners == 0) return 0;
    tip = tip / corners;
    double sixfold = 0;
    for (const Polygon& face : faces) {
        Vec3 area(0);
        for (std::size_t i = 2; i < face.size(); ++i) area += (face[i - 1] - face[0]).cross(face[i] - face[0]);
        sixfold += std::abs(area.dot(face[0] - tip));
    }
    return sixfold / 6;
}

}  // namespace

double volumeInCube(const Vec3& center, const std::vector<HalfSpace>& spaces) {
    static const Polyhedron kCube = unitCube();
    Polyhedron rest;  // empty as long as it is the cube
    for (HalfSpace space : spaces) {
        space.offset -= space.normal.dot(center);
        const Vec3& n = space.normal;
        const double reach = 0.5 * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
        if (space.offset >= reach) continue;
        if (space.offset <= -reach) return 0;
        rest = clipped(rest.empty() ? kCube : rest, space);
        if (rest.empty()) return 0;
    }
    return rest.empty() ? 1 : volumeOf(rest);
}

}  // namespace raysweep
