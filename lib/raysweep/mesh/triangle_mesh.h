/// Surfaces made of triangles.
#pragma once

#include "raysweep/core/types.h"

#include <array>
#include <cstdint>
#include <vector>

namespace raysweep {

/// Corners and the triangles between them. Vectors of things per corner are empty or as long as `positions`.
struct TriangleMesh {
    using Triangle = std::array<std::uint32_t, 3>;  ///< indices of corners, counter-clockwise seen from the front

    std::vector<Vec3> positions;                ///< world units
    std::vector<Color> colors;                  ///< linear RGB in [0,1]
    std::vector<std::array<float, 2>> texture;  ///< u to the right and v upwards in a picture, [0,1] within it
    std::vector<Triangle> triangles;
};

/// The cross product of two edges: its length is twice the area, its direction the front's.
inline Vec3 doubleArea(const TriangleMesh& mesh, const TriangleMesh::Triangle& t) {
    const Vec3& a = mesh.positions[t[0]];
    return (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a);
}

/// Unit normals at the corners: means of those of the triangles around, weighted by their angles there (Thuermer and
/// Wuethrich 1998), which do not depend on how a surface is cut into triangles. Corners in one place share theirs where
/// it is less than 30 degrees from their own, so that edges stay edges. 0 at corners without a triangle.
std::vector<Vec3> cornerNormals(const TriangleMesh& mesh);

/// For every corner the number of the first one in exactly the same place.
std::vector<std::uint32_t> firstAtSamePlace(const TriangleMesh& mesh);

/// Adds the corners and triangles of `other`. What only one of them has per corner the other is given: white, (0,0).
void append(TriangleMesh& mesh, const TriangleMesh& other);

}  // namespace raysweep
