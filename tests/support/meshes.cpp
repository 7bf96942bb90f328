#include "support/meshes.h"

#include <algorithm>
#include <map>
#include <utility>

namespace raysweep::test {

TriangleMesh sphereMesh(const Vec3& center, double radius, int cuts) {
    TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (int sign = -1; sign <= 1; sign += 2) {
            mesh.positions.emplace_back(0, 0, 0);
            mesh.positions.back()[axis] = sign;
        }
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
        const std::uint32_t x = octant & 1, y = octant >> 1 & 1, z = octant >> 2 & 1;
        TriangleMesh::Triangle t{x, 2 + y, 4 + z};
        if ((x + y + z) % 2 == 0) std::swap(t[0], t[1]);
        mesh.triangles.push_back(t);
    }
    for (int cut = 0; cut < cuts; ++cut) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [at, isNew] = middles.try_emplace(std::minmax(a, b), std::uint32_t(mesh.positions.size()));
            if (isNew) mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]).normalized());
            return at->second;
        };
        std::vector<TriangleMesh::Triangle> finer;
        for (const auto& [a, b, c] : mesh.triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            for (const TriangleMesh::Triangle& t :
                 {TriangleMesh::Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
                finer.push_back(t);
        }
        mesh.triangles = std::move(finer);
    }
    for (Vec3& p : mesh.positions) p = center + p * radius;
    return mesh;
}

TriangleMesh boxMesh(const Vec3& low, const Vec3& high) {
    TriangleMesh mesh;
    for (int corner = 0; corner < 8; ++corner)
        mesh.positions.emplace_back(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                    corner & 4 ? high.z : low.z);
    for (const auto& [a, b, c, d] : {std::array<std::uint32_t, 4>{0, 4, 6, 2},
                                     {1, 3, 7, 5},
                                     {0, 1, 5, 4},
                                     {2, 6, 7, 3},
                                     {0, 2, 3, 1},
                                     {4, 5, 7, 6}}) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    }
    return mesh;
}

TriangleMesh squareMesh(double side, double z, int cells) {
    TriangleMesh mesh;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x) {
            mesh.positions.emplace_back(side * x / cells, side * y / cells, z);
            mesh.texture.push_back({float(x) / float(cells), float(y) / float(cells)});
        }
    const std::uint32_t line = std::uint32_t(cells) + 1;
    for (std::uint32_t y = 0; y + 1 < line; ++y)
        for (std::uint32_t x = 0; x + 1 < line; ++x) {
            const std::uint32_t a = y * line + x;
            mesh.triangles.push_back({a, a + 1, a + line + 1});
            mesh.triangles.push_back({a, a + line + 1, a + line});
        }
    return mesh;
}

TriangleMesh turned(TriangleMesh mesh) {
    for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

}  // namespace raysweep::test
