#include "raysweep/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace raysweep {
namespace {

bool isBefore(const Vec3& a, const Vec3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// Between the edges that meet at a corner of a triangle, rad.
double angleAt(const TriangleMesh& mesh, const TriangleMesh::Triangle& t, std::size_t corner) {
    const Vec3& at = mesh.positions[t[corner]];
    const Vec3 a = mesh.positions[t[(corner + 1) % 3]] - at, b = mesh.positions[t[(corner + 2) % 3]] - at;
    return std::atan2(a.cross(b).length(), a.dot(b));
}

/// Makes both sides have `values` per corner, or none.
template <class Value>
void appendPerCorner(std::vector<Value>& to, std::size_t corners, const std::vector<Value>& from,
                     std::size_t newCorners, const Value& missing) {
    if (to.empty() && from.empty()) return;
    to.resize(corners, missing);
    to.insert(to.end(), from.begin(), from.end());
    to.resize(corners + newCorners, missing);
}

}  // namespace

std::vector<std::uint32_t> firstAtSamePlace(const TriangleMesh& mesh) {
    const std::vector<Vec3>& p = mesh.positions;
    std::vector<std::uint32_t> order(p.size()), first(p.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return p[a] == p[b] ? a < b : isBefore(p[a], p[b]); });
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] = i > 0 && p[order[i]] == p[order[i - 1]] ? first[order[i - 1]] : order[i];
    return first;
}

std::vector<Vec3> cornerNormals(const TriangleMesh& mesh) {
    const std::vector<std::uint32_t> first = firstAtSamePlace(mesh);
    std::vector<Vec3> own(mesh.positions.size(), Vec3(0)), shared = own;
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
        const Vec3 front = doubleArea(mesh, t).normalized();
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 weighted = front * angleAt(mesh, t, i);
            own[t[i]] += weighted, shared[first[t[i]]] += weighted;
        }
    }
    for (std::size_t i = 0; i < own.size(); ++i) {
        const Vec3 alone = own[i].normalized(), together = shared[first[i]].normalized();
        own[i] = alone.dot(together) > 0.866 ? together : alone;
    }
    return own;
}

void append(TriangleMesh& mesh, const TriangleMesh& other) {
    const std::size_t corners = mesh.positions.size(), newCorners = other.positions.size();
    appendPerCorner(mesh.colors, corners, other.colors, newCorners, Color(1, 1, 1));
    appendPerCorner(mesh.texture, corners, other.texture, newCorners, {0, 0});
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (TriangleMesh::Triangle t : other.triangles) {
        for (std::uint32_t& corner : t) corner += std::uint32_t(corners);
        mesh.triangles.push_back(t);
    }
}

}  // namespace raysweep
