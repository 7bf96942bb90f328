/// Meshes in files: Wavefront OBJ, PLY and STL.
#pragma once

#include "raysweep/mesh/triangle_mesh.h"

#include <string>

namespace raysweep {

/// Whether the name of a file ends with .obj, .ply or .stl, whatever its case.
bool isMeshFile(const std::string& path);

/// What the numbers of colours in files mean: formats do not say.
enum class ColorEncoding {
    srgb,   ///< as displays take them: decoded
    linear  ///< radiometric
};

/// Reads a mesh by Assimp: all objects of the file together; polygons are cut into triangles, points and lines left
/// out. Colours are those of its corners (PLY, STL, and OBJ as many programs write it), or else the diffuse ones of
/// OBJ's materials. Coordinates are single floats, in the file's own axes.
/// @throw IoError if the file is missing, is no such mesh, is damaged or holds no triangle, if coordinates are no
/// finite numbers, or the module that reads meshes is missing.
TriangleMesh readMesh(const std::string& path, ColorEncoding encoding = ColorEncoding::srgb);

/// Writes a binary PLY: corners with normals, colours and texture coordinates `s`, `t` where the mesh has them, and
/// triangles. Colours are bytes as displays take them, [0,1] of linear light, which is what programs that show PLY
/// expect; or linear floats of any size. It appears whole or not at all.
/// @throw InvalidArgument if the name does not end with .ply  @throw IoError if it cannot be written
void writePly(const std::string& path, const TriangleMesh& mesh, ColorEncoding encoding = ColorEncoding::srgb);

}  // namespace raysweep
