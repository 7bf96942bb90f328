// PLY of our own hand: libraries write its colours in 8 bits, and radiosity has no upper end.
#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/text_file.h"
#include "raysweep/mesh/mesh_files.h"

#include <cstring>

namespace raysweep {
namespace {

static_assert(sizeof(float) == 4, "PLY's float");

std::string headerOf(const TriangleMesh& mesh) {
    std::string header = "ply\nformat binary_little_endian 1.0\ncomment Raysweep: colours are linear\nelement vertex " +
                         std::to_string(mesh.positions.size()) + "\n";
    const auto property = [&](const char* name) { header += std::string("property float ") + name + "\n"; };
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) property(name);
    if (!mesh.colors.empty())
        for (const char* name : {"red", "green", "blue"}) property(name);
    if (!mesh.texture.empty())
        for (const char* name : {"s", "t"}) property(name);
    return header + "element face " + std::to_string(mesh.triangles.size()) +
           "\nproperty list uchar uint vertex_indices\nend_header\n";
}

/// Adds the bytes of `value`, low ones first, as all machines have them that this is built for.
template <class Value>
void add(std::string& bytes, Value value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
}

void add(std::string& bytes, const Vec3& v) {
    for (int axis = 0; axis < 3; ++axis) add(bytes, float(v[axis]));
}

}  // namespace

void writePly(const std::string& path, const TriangleMesh& mesh) {
    if (lowerExtension(path) != ".ply") throw InvalidArgument("'" + path + "': meshes are written as .ply");
    std::string bytes = headerOf(mesh);
    const std::vector<Vec3> normals = cornerNormals(mesh);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        add(bytes, mesh.positions[i]);
        add(bytes, normals[i]);
        for (int c = 0; c < 3 && !mesh.colors.empty(); ++c) add(bytes, mesh.colors[i][c]);
        for (int c = 0; c < 2 && !mesh.texture.empty(); ++c) add(bytes, mesh.texture[i][std::size_t(c)]);
    }
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
        add(bytes, std::uint8_t(3));
        for (const std::uint32_t corner : t) add(bytes, corner);
    }
    writeText(path, bytes);
}

}  // namespace raysweep
