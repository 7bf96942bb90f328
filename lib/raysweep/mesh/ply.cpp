// PLY of our own hand: libraries write its colours in 8 bits, and radiosity has no upper end.
#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/text_file.h"
#include "raysweep/image/image_io.h"
#include "raysweep/mesh/mesh_files.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace raysweep {
namespace {

static_assert(sizeof(float) == 4, "PLY's float");

std::string headerOf(const TriangleMesh& mesh, ColorEncoding encoding) {
    std::string header =
        "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.positions.size()) + "\n";
    const auto add = [&](const std::string& type, std::initializer_list<const char*> names) {
        for (const std::string name : names) header += "property " + type + " " + name + "\n";
    };
    add("float", {"x", "y", "z", "nx", "ny", "nz"});
    if (!mesh.colors.empty()) add(encoding == ColorEncoding::srgb ? "uchar" : "float", {"red", "green", "blue"});
    if (!mesh.texture.empty()) add("float", {"s", "t"});
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

void add(std::string& bytes, const Color& color, ColorEncoding encoding) {
    for (int c = 0; c < 3; ++c) {
        if (encoding == ColorEncoding::srgb)
            add(bytes, std::uint8_t(std::lround(255 * srgbFromLinear(std::clamp(color[c], 0.0f, 1.0f)))));
        else
            add(bytes, color[c]);
    }
}

}  // namespace

void writePly(const std::string& path, const TriangleMesh& mesh, ColorEncoding encoding) {
    if (lowerExtension(path) != ".ply") throw InvalidArgument("'" + path + "': meshes are written as .ply");
    std::string bytes = headerOf(mesh, encoding);
    const std::vector<Vec3> normals = cornerNormals(mesh);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        add(bytes, mesh.positions[i]);
        add(bytes, normals[i]);
        if (!mesh.colors.empty()) add(bytes, mesh.colors[i], encoding);
        for (int c = 0; c < 2 && !mesh.texture.empty(); ++c) add(bytes, mesh.texture[i][std::size_t(c)]);
    }
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
        add(bytes, std::uint8_t(3));
        for (const std::uint32_t corner : t) add(bytes, corner);
    }
    writeText(path, bytes);
}

}  // namespace raysweep
