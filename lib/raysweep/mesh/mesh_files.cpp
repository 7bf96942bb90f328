#include "raysweep/mesh/mesh_files.h"

#include "raysweep/core/error.h"
#include "raysweep/core/file_name.h"
#include "raysweep/core/finite.h"
#include "raysweep/core/module.h"
#include "raysweep/core/regular_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/image/image_io.h"
#include "raysweep/mesh/mesh_formats.h"

#include <algorithm>

namespace raysweep {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

const MeshFormats& formatsFor(const std::string& path) {
    static const ModuleFunction found = moduleFunction("raysweep_meshes", "raysweepMeshFormats");
    if (!found.address) fail(path, "meshes are read by Assimp, which this build does not have (" + found.problem + ")");
    const MeshFormats& formats = *reinterpret_cast<const MeshFormats* (*)()>(found.address)();
    if (formats.version != kMeshFormatsVersion)
        fail(path, "the module 'raysweep_meshes.so' belongs to another build; build or install it again");
    return formats;
}

void requireUsable(const std::string& path, const TriangleMesh& mesh) {
    if (mesh.triangles.empty()) fail(path, "it holds no triangle or polygon");
    const auto bad = std::find_if_not(mesh.positions.begin(), mesh.positions.end(), isFinite);
    if (bad != mesh.positions.end())
        fail(path, "the place of corner " + std::to_string(bad - mesh.positions.begin()) + " is no finite number");
    for (const TriangleMesh::Triangle& t : mesh.triangles)
        if (std::max({t[0], t[1], t[2]}) >= mesh.positions.size())
            fail(path, "a triangle has a corner that is missing");
}

/// Colours within [0,1]; what is no number becomes 0.
float decoded(float value, ColorEncoding encoding) {
    const float within = value > 0 ? std::min(value, 1.0f) : 0.0f;
    return encoding == ColorEncoding::srgb ? linearFromSrgb(within) : within;
}

}  // namespace

bool isMeshFile(const std::string& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".obj" || extension == ".ply" || extension == ".stl";
}

TriangleMesh readMesh(const std::string& path, ColorEncoding encoding) {
    noteInput(path);
    if (const std::string why = whyNotRegular(path, "a mesh (.obj, .ply, .stl)"); !why.empty()) fail(path, why);
    if (!isMeshFile(path)) fail(path, "it is no mesh by its name; give an .obj, .ply or .stl file");
    TriangleMesh mesh;
    const std::string problem = formatsFor(path).read(path, lowerExtension(path).substr(1), mesh);
    if (!problem.empty()) fail(path, problem);
    requireUsable(path, mesh);
    for (Color& color : mesh.colors)
        for (int c = 0; c < 3; ++c) color[c] = decoded(color[c], encoding);
    return mesh;
}

}  // namespace raysweep
