/// Meshes for tests.
#pragma once

#include "raysweep/mesh/triangle_mesh.h"

namespace raysweep::test {

/// An octahedron whose triangles were cut into four `cuts` times, corners on the sphere. It faces outwards.
TriangleMesh sphereMesh(const Vec3& center, double radius, int cuts);

/// A box of 8 corners and 12 triangles that faces outwards.
TriangleMesh boxMesh(const Vec3& low, const Vec3& high);

/// A square at height z, cells x cells squares of two triangles, facing up. It has texture coordinates.
TriangleMesh squareMesh(double side, double z, int cells);

/// The same with every triangle's other face in front.
TriangleMesh turned(TriangleMesh mesh);

}  // namespace raysweep::test
