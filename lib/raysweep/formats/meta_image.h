/// MetaImage volumes. Nothing here needs more than zlib: what writes them is in itk_volume.h.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/formats/volume_choice.h"

#include <string>

namespace raysweep {

/// Reads MetaImage (.mha, .mhd): binary, compressed or text, in the file itself, in another, in a list of files or in
/// numbered ones. Intensities are those of its function (slope and offset). A fourth dimension counts volumes.
/// @throw IoError for what is missing, malformed or truncated. @throw InvalidArgument for what cannot be used, and
/// where it holds several channels or volumes and none was chosen.
StoredVolume readMetaImage(const std::string& path, const VolumeChoice& choice = {},
                           const ProgressCallback& progress = {});

}  // namespace raysweep
