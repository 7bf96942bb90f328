/// NRRD volumes.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/formats/volume_choice.h"

#include <string>

namespace raysweep {

/// Reads NRRD, its header attached or detached: raw, gzip, text and hex. Axes of space (kinds domain and space, or
/// those with a direction) are i, j, k in the file's order; time and list are volumes, other kinds channels. Positions
/// are the file's, turned to LPS where its space is RAS or LAS.
/// @throw IoError for what is missing, malformed or truncated. @throw InvalidArgument for what cannot be used, and
/// where it holds several channels or volumes and none was chosen.
StoredVolume readNrrd(const std::string& path, const VolumeChoice& choice = {}, const ProgressCallback& progress = {});

}  // namespace raysweep
