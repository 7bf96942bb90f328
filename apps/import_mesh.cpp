#include "import_mesh.h"

#include "cli.h"
#include "hints.h"

#include "raysweep/core/output_file.h"
#include "raysweep/volume/vdb_io.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>

namespace raysweep::apps {
namespace {

constexpr const char* kGroup = "Meshes";

const std::map<std::string, ColorEncoding> kEncodings = {{"srgb", ColorEncoding::srgb},
                                                         {"linear", ColorEncoding::linear}};

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// Says what is not as a modeller will have meant it, and what was made of it.
void comment(const CommonOptions& common, const MeshVolume& volume, double voxel) {
    const MeshShells& shells = volume.shells;
    if (volume.sheets > 0)
        message(common, counted(volume.sheets, "open surface was", "open surfaces were") + " taken as sheets of " +
                            brief(volume.thickness, 3) +
                            " voxels: " + counted(shells.openEdges, "edge has", "edges have") +
                            " one triangle only, in " + counted(shells.holes, "rim or hole", "rims or holes"));
    if (shells.turned > 0)
        warning(common, counted(shells.turned, "triangle faces", "triangles face") +
                            " otherwise than those around, and was turned");
    if (volume.inwards > 0)
        message(common, counted(volume.inwards, "closed surface faces", "closed surfaces face") +
                            " inwards: hollow within others, else filled");
    if (shells.forkedEdges > 0)
        detail(common, counted(shells.forkedEdges, "edge has", "edges have") + " more than two triangles");
    if (shells.degenerate > 0)
        warning(common,
                counted(shells.degenerate, "triangle without area was", "triangles without area were") + " left out");
    if (volume.thin > 0)
        warning(common, counted(volume.thin, "solid is", "solids are") + " thinner than a voxel (" + brief(voxel, 3) +
                            ") and will let light through; give a smaller --voxel-size or a larger --size");
}

nlohmann::ordered_json describe(const MeshVolume& volume, const TriangleMesh& mesh, double voxel, double seconds) {
    return {{"format", "mesh"},
            {"triangles", mesh.triangles.size()},
            {"voxel_size", voxel},
            {"solids", volume.solids},
            {"inwards", volume.inwards},
            {"sheets", volume.sheets},
            {"open_edges", volume.shells.openEdges},
            {"holes", volume.shells.holes},
            {"forked_edges", volume.shells.forkedEdges},
            {"triangles_turned", volume.shells.turned},
            {"degenerate", volume.shells.degenerate},
            {"thin", volume.thin},
            {"colours", !mesh.colors.empty()},
            {"voxels_active", volume.density->activeVoxelCount()},
            {"seconds", seconds}};
}

/// Whether options of a group of `import` are about samples and their files.
bool isForVolumes(const std::string& group) {
    return group != kGroup && group != "Options" && group != "Output" && group != "Common options";
}

}  // namespace

void addMeshOptions(CLI::App& app, MeshArguments& mesh) {
    app.option_defaults()->group(kGroup);
    app.add_option("--voxel-size", mesh.options.voxelSize, "Edge of a voxel, world units")->type_name("S");
    app.add_option("--size", mesh.options.size, "Without it: voxels along the longest side of the meshes' box")
        ->capture_default_str()
        ->type_name("N");
    app.add_option("--thickness", mesh.options.thickness, "Of surfaces that are not closed, voxels")
        ->capture_default_str()
        ->type_name("T");
    app.add_flag("--merge", mesh.merge, "Put several meshes into one volume");
    app.add_option("--colors", mesh.encoding, "What colours of meshes are: as displays show them, or linear light")
        ->check(CLI::IsMember(kEncodings).description(""))
        ->type_name("srgb|linear")
        ->capture_default_str();
}

bool requireMeshOptions(const std::vector<std::string>& files, const MeshArguments& mesh, const CLI::App& command) {
    const auto meshes = std::count_if(files.begin(), files.end(), isMeshFile);
    const bool areMeshes = meshes > 0;
    if (areMeshes && std::size_t(meshes) < files.size())
        usageError("files", "meshes and other files cannot be imported together");
    if (meshes > 1 && !mesh.merge) usageError("files", "several meshes need --merge, which puts them into one volume");
    for (const CLI::Option* option : command.get_options()) {
        const std::string &group = option->get_group(), name = option->get_name();
        if (option->count() == 0) continue;
        if (!areMeshes && group == kGroup) usageError(name, "is for meshes (.obj, .ply, .stl)");
        if (areMeshes && isForVolumes(group)) usageError(name, "means nothing to meshes");
    }
    requireValid(command, [&] { mesh.options.validate(); });
    return areMeshes;
}

int importMeshes(const std::vector<std::string>& files, const MeshArguments& a, const std::string& output, bool half,
                 const CommonOptions& common) {
    const Timer timer;
    TerminalProgress progress(common);
    TriangleMesh mesh;
    for (const std::string& file : files) append(mesh, readMesh(file, kEncodings.at(a.encoding)));
    const MeshVolume volume = meshToVolume(mesh, a.options, progress.callback());
    if (!volume.density || TerminalProgress::interrupted()) {
        message(common, "stopped; nothing was written");
        return kInterrupted;
    }
    openvdb::GridCPtrVec grids{volume.density};
    if (volume.color) grids.push_back(volume.color);
    for (const auto& grid : grids) {
        const auto changed = std::const_pointer_cast<openvdb::GridBase>(grid);
        changed->setSaveFloatAsHalf(half);
        changed->insertMeta("raysweep_version", openvdb::StringMetadata(RAYSWEEP_VERSION));
    }
    writeVdb(output, grids);
    const double voxel = volume.density->voxelSize()[0];
    comment(common, volume, voxel);
    writeReport(common, describe(volume, mesh, voxel, timer.seconds()));
    return kDone;
}

}  // namespace raysweep::apps
