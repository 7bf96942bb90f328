/// The module `raysweep_meshes`: Assimp. It uses nothing of the library but headers.
#include "raysweep/mesh/mesh_formats.h"

#include <assimp/BaseImporter.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

namespace raysweep {
namespace {

/// Diffuse colour of a material that the file itself names; what Assimp puts in its place does not count.
bool materialColor(const aiMaterial& material, const std::string& extension, aiColor3D& color) {
    aiString name;
    material.Get(AI_MATKEY_NAME, name);
    return extension == "obj" && std::string(name.C_Str()) != AI_DEFAULT_MATERIAL_NAME &&
           material.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS;
}

void addColors(TriangleMesh& mesh, const aiMesh& part, const aiScene& scene, const std::string& extension) {
    aiColor3D diffuse(1, 1, 1);
    const bool own = part.HasVertexColors(0);
    if (!own && !materialColor(*scene.mMaterials[part.mMaterialIndex], extension, diffuse)) return;
    mesh.colors.reserve(part.mNumVertices);
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const aiColor4D c = own ? part.mColors[0][i] : aiColor4D(diffuse.r, diffuse.g, diffuse.b, 1);
        mesh.colors.emplace_back(c.r, c.g, c.b);
    }
}

TriangleMesh meshOf(const aiMesh& part, const aiScene& scene, const std::string& extension) {
    TriangleMesh mesh;
    mesh.positions.reserve(part.mNumVertices);
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const aiVector3D& p = part.mVertices[i];
        mesh.positions.emplace_back(p.x, p.y, p.z);
    }
    addColors(mesh, part, scene, extension);
    for (unsigned i = 0; part.HasTextureCoords(0) && i < part.mNumVertices; ++i)
        mesh.texture.push_back({part.mTextureCoords[0][i].x, part.mTextureCoords[0][i].y});
    for (unsigned i = 0; i < part.mNumFaces; ++i)
        if (part.mFaces[i].mNumIndices == 3)
            mesh.triangles.push_back(
                {part.mFaces[i].mIndices[0], part.mFaces[i].mIndices[1], part.mFaces[i].mIndices[2]});
    return mesh;
}

/// The library goes by what a file looks like, too, and knows dozens of formats more.
void keepOnly(Assimp::Importer& importer, const std::string& extension) {
    const Assimp::BaseImporter* const kept = importer.GetImporter(extension.c_str());
    for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
        Assimp::BaseImporter* const other = importer.GetImporter(i);
        if (other == kept) continue;
        importer.UnregisterLoader(other);
        delete other;
    }
}

std::string read(const std::string& path, const std::string& extension, TriangleMesh& mesh) {
    Assimp::Importer importer;
    keepOnly(importer, extension);
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const aiScene* const scene =
        importer.ReadFile(path, aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
                                    aiProcess_PreTransformVertices | aiProcess_ValidateDataStructure);
    if (!scene) return importer.GetErrorString();
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) append(mesh, meshOf(*scene->mMeshes[i], *scene, extension));
    return "";
}

}  // namespace
}  // namespace raysweep

extern "C" const raysweep::MeshFormats* raysweepMeshFormats() {
    static constexpr raysweep::MeshFormats kFormats{raysweep::kMeshFormatsVersion, raysweep::read};
    return &kFormats;
}
