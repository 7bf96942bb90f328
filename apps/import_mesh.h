/// `raysweep import` of meshes.
#pragma once

#include "command.h"

#include "raysweep/mesh/mesh_files.h"
#include "raysweep/mesh/mesh_volume.h"

#include <string>
#include <vector>

namespace raysweep::apps {

/// What the user typed.
struct MeshArguments {
    MeshVolumeOptions options;
    bool merge = false;
    std::string encoding = "srgb";
};

void addMeshOptions(CLI::App& app, MeshArguments& mesh);

/// True if `files` are meshes by their names. Checks that meshes come with no options but theirs, and other files with
/// none of theirs. @throw CLI::ValidationError
bool requireMeshOptions(const std::vector<std::string>& files, const MeshArguments& mesh, const CLI::App& command);

/// Reads the meshes, and writes a volume of all of them together. @return exit code @throw IoError, InvalidArgument
int importMeshes(const std::vector<std::string>& files, const MeshArguments& mesh, const std::string& output, bool half,
                 const CommonOptions& common);

}  // namespace raysweep::apps
