/// What passes between the library and the module `raysweep_meshes`, which holds Assimp; loaded when a mesh is read.
#pragma once

#include "raysweep/mesh/triangle_mesh.h"

#include <string>

namespace raysweep {

/// To be counted up whenever something that passes changes.
constexpr int kMeshFormatsVersion = 1;
struct MeshFormats {
    int version;
    /// The mesh as the file has it, colours not decoded. @param extension what it is read as: "obj", "ply", "stl"
    /// @return why it could not be read, empty if it could
    std::string (*read)(const std::string& path, const std::string& extension, TriangleMesh& mesh);
};

}  // namespace raysweep
