/// What a mesh is made of: closed surfaces, which have an inside, and open ones, which do not.
#pragma once

#include "raysweep/mesh/triangle_mesh.h"

#include <cstddef>
#include <vector>

namespace raysweep {

/// Triangles that hang together by edges that two of them share. Corners in exactly the same place are one.
struct MeshShell {
    std::vector<std::uint32_t> triangles;  ///< indices
    std::vector<char> turned;  ///< of each: it shows its back where most of the shell's area shows its front
    bool closed = true;        ///< no edge has one triangle only, and it has two sides (a Klein bottle: one)
    double area = 0;           ///< world units
    double volume = 0;         ///< within a closed shell as most of it faces; below 0 if that is inwards
};

struct MeshShells {
    std::vector<MeshShell> shells;  ///< by their first triangles
    std::size_t degenerate = 0;     ///< triangles without area, which belong to no shell
    std::size_t turned = 0;         ///< triangles that face otherwise than their shells
    std::size_t openEdges = 0;      ///< of one triangle
    std::size_t holes = 0;          ///< chains of open edges; an open sheet has one along its rim
    std::size_t forkedEdges = 0;    ///< of three triangles or more
};

MeshShells shellsOf(const TriangleMesh& mesh);

/// `mesh` with its turned triangles facing as their shells do.
TriangleMesh facingAlike(TriangleMesh mesh, const MeshShells& shells);

}  // namespace raysweep
