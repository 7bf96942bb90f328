#include "raysweep/mesh/mesh_shells.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace raysweep {
namespace {

/// Which of the things 0, 1 ... hang together, and which of those face the same way.
class Groups {
  public:
    explicit Groups(std::size_t count) : parent_(count), against_(count) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    struct Member {
        std::uint32_t first;  ///< of its group
        bool against;         ///< faces otherwise than that
    };

    Member of(std::uint32_t i) {
        bool against = false;
        for (; parent_[i] != i; i = parent_[i]) {
            // Halves the way for those who come after.
            const std::uint32_t next = parent_[i];
            against_[i] = char(against_[i] ^ against_[next]);
            parent_[i] = parent_[next];
            against = against != bool(against_[i]);
        }
        return {i, against};
    }

    /// @return false if it was known otherwise
    bool join(std::uint32_t a, std::uint32_t b, bool against) {
        Member low = of(a), high = of(b);
        const bool firstsAgainst = (low.against != high.against) != against;
        if (low.first == high.first) return !firstsAgainst;
        if (low.first > high.first) std::swap(low, high);
        parent_[high.first] = low.first;
        against_[high.first] = firstsAgainst;
        return true;
    }

  private:
    std::vector<std::uint32_t> parent_;
    std::vector<char> against_;  ///< its parent; of a first one 0
};

/// A triangle's edge between two places.
struct Edge {
    std::uint32_t low, high, triangle;
    bool forward;  ///< the triangle goes from low to high

    bool isWith(const Edge& other) const { return low == other.low && high == other.high; }
};

bool isBefore(const Edge& a, const Edge& b) {
    return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
}

std::vector<Edge> edgesOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& place,
                          const std::vector<char>& degenerate) {
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (std::size_t side = 0; side < 3 && !degenerate[i]; ++side) {
            const std::uint32_t a = place[mesh.triangles[i][side]], b = place[mesh.triangles[i][(side + 1) % 3]];
            edges.push_back({std::min(a, b), std::max(a, b), std::uint32_t(i), a < b});
        }
    std::sort(edges.begin(), edges.end(), isBefore);
    return edges;
}

/// Calls `visit(first, count)` for every edge, with the triangles' sides that lie along it.
template <class Visit>
void forEachEdge(const std::vector<Edge>& edges, const Visit& visit) {
    for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
        for (end = begin + 1; end < edges.size() && edges[end].isWith(edges[begin]);) ++end;
        visit(&edges[begin], end - begin);
    }
}

void countHoles(const std::vector<Edge>& edges, std::size_t places, MeshShells& found) {
    Groups rims(places);
    std::vector<std::uint32_t> onRim;
    forEachEdge(edges, [&](const Edge* edge, std::size_t count) {
        if (count != 1) return;
        rims.join(edge->low, edge->high, false);
        onRim.push_back(edge->low);
    });
    for (std::uint32_t& corner : onRim) corner = rims.of(corner).first;
    std::sort(onRim.begin(), onRim.end());
    found.holes = std::size_t(std::unique(onRim.begin(), onRim.end()) - onRim.begin());
}

std::vector<char> degenerateTriangles(const TriangleMesh& mesh) {
    std::vector<char> degenerate(mesh.triangles.size());
    for (std::size_t i = 0; i < degenerate.size(); ++i)
        degenerate[i] = !(doubleArea(mesh, mesh.triangles[i]).length() > 0);
    return degenerate;
}

/// The shell of each triangle, by its first.
std::map<std::uint32_t, MeshShell> collect(const TriangleMesh& mesh, const std::vector<char>& degenerate,
                                           const std::vector<char>& open, Groups& groups) {
    std::map<std::uint32_t, MeshShell> shells;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        if (degenerate[i]) continue;
        const Groups::Member member = groups.of(i);
        MeshShell& shell = shells[member.first];
        shell.triangles.push_back(i);
        shell.turned.push_back(member.against);
        shell.closed = shell.closed && !open[i];
    }
    return shells;
}

/// Area, volume, and which way most of the shell faces.
void measure(const TriangleMesh& mesh, MeshShell& shell) {
    const Vec3 from = mesh.positions[mesh.triangles[shell.triangles[0]][0]];  // near: no digits are lost
    double against = 0;
    for (std::size_t i = 0; i < shell.triangles.size(); ++i) {
        const TriangleMesh::Triangle& t = mesh.triangles[shell.triangles[i]];
        const Vec3 area = doubleArea(mesh, t) / 2;
        shell.area += area.length();
        shell.volume += (shell.turned[i] ? -1 : 1) * (mesh.positions[t[0]] - from).dot(area) / 3;
        against += shell.turned[i] ? area.length() : 0;
    }
    if (2 * against <= shell.area) return;
    for (char& turned : shell.turned) turned = !turned;
    shell.volume = -shell.volume;
}

}  // namespace

MeshShells shellsOf(const TriangleMesh& mesh) {
    MeshShells found;
    const std::vector<char> degenerate = degenerateTriangles(mesh);
    found.degenerate = std::size_t(std::count(degenerate.begin(), degenerate.end(), char(1)));
    Groups groups(mesh.triangles.size());
    const std::vector<Edge> edges = edgesOf(mesh, firstAtSamePlace(mesh), degenerate);
    std::vector<char> open(mesh.triangles.size());
    forEachEdge(edges, [&](const Edge* edge, std::size_t count) {
        found.openEdges += count == 1, found.forkedEdges += count > 2;
        if (count == 1) open[edge->triangle] = 1;
        if (count != 2) return;
        // Triangles that face alike go along their edge in opposite ways.
        if (!groups.join(edge[0].triangle, edge[1].triangle, edge[0].forward == edge[1].forward))
            open[edge->triangle] = 1;
    });
    countHoles(edges, mesh.positions.size(), found);
    for (auto& [first, shell] : collect(mesh, degenerate, open, groups)) {
        measure(mesh, shell);
        found.turned += std::size_t(std::count(shell.turned.begin(), shell.turned.end(), char(1)));
        found.shells.push_back(std::move(shell));
    }
    return found;
}

TriangleMesh facingAlike(TriangleMesh mesh, const MeshShells& shells) {
    for (const MeshShell& shell : shells.shells)
        for (std::size_t i = 0; i < shell.triangles.size(); ++i) {
            TriangleMesh::Triangle& t = mesh.triangles[shell.triangles[i]];
            if (shell.turned[i]) std::swap(t[1], t[2]);
        }
    return mesh;
}

}  // namespace raysweep
