// What is inside of surfaces, against which side of its faces a place is on.
#include "raysweep/mesh/mesh_winding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <utility>

#include "raysweep/core/progress.h"

using namespace raysweep;

namespace {

/// Four corners and four faces, outwards.
TriangleMesh tetrahedron(const Vec3 (&corners)[4]) {
    TriangleMesh mesh;
    mesh.positions.assign(std::begin(corners), std::end(corners));
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    if ((corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[3] - corners[0]) < 0)
        for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
    return mesh;
}

/// How far `p` is behind the face that is nearest to it: above 0 inside.
double depthOf(const TriangleMesh& mesh, const Vec3& p) {
    double depth = 1e300;
    for (const TriangleMesh::Triangle& t : mesh.triangles)
        depth = std::min(depth, (mesh.positions[t[0]] - p).dot(doubleArea(mesh, t).normalized()));
    return depth;
}

MeshPart all(const TriangleMesh& mesh) {
    MeshPart part{mesh, {}};
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) part.triangles.push_back(i);
    return part;
}

}  // namespace

// But for voxels whose centres lie on faces, to the thousandth of a voxel that corners are moved.
TEST(MeshWinding, AgreesWithWhichSideOfItsFacesAPlaceIsOn) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(0, 20);
    const MeshLattice lattice;
    for (int n = 0; n < 40; ++n) {
        Vec3 corners[4];
        for (Vec3& corner : corners) {
            corner = Vec3(place(random), place(random), place(random));
            if (n % 2) corner = Vec3(std::round(corner.x), std::round(corner.y), std::round(corner.z));
        }
        if (n % 4 == 2) corners[1] = corners[0] + Vec3(0, 12, 3), corners[2].x = corners[3].x;  // edges across x
        const TriangleMesh mesh = tetrahedron(corners);
        const MeshWinding winding(all(mesh), lattice);
        for (int i = -1; i <= 21; ++i)
            for (int j = -1; j <= 21; ++j)
                for (int k = -1; k <= 21; ++k) {
                    const double depth = depthOf(mesh, Vec3(i + 0.5, j + 0.5, k + 0.5));
                    if (std::abs(depth) < 2e-3) continue;
                    EXPECT_EQ(winding.numberAt({i, j, k}), depth > 0) << n << ": " << i << " " << j << " " << k;
                }
    }
}

// Each of its faces has a box of 65536 x 65536 rays, of which it meets a few in a column; to try all takes minutes.
TEST(MeshWinding, SliversAlongTheDiagonalTakeNoTime) {
    constexpr double kLong = 65536;
    const TriangleMesh mesh = tetrahedron({Vec3(0, 0, 4), Vec3(8, 0, 4), Vec3(kLong, kLong, 0), Vec3(kLong, kLong, 8)});
    const Timer timer;
    const MeshWinding winding(all(mesh), MeshLattice());
    EXPECT_LT(timer.seconds(), 5);                // 0.03 found
    for (const int at : {10000, 30000, 50000}) {  // 6.8 to 1.9 wide, 1.2 to 6.1 high
        EXPECT_EQ(winding.numberAt({at + 1, at, 3}), 1) << at;
        EXPECT_EQ(winding.numberAt({at + 1, at, 8}), 0) << at;
        EXPECT_EQ(winding.numberAt({at + 9, at, 3}), 0) << at;
        EXPECT_EQ(winding.numberAt({at - 1, at, 3}), 0) << at;
    }
}
