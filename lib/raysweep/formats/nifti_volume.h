/// NIfTI volumes.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/formats/volume_choice.h"

#include <string>

namespace raysweep {

/// Reads NIfTI-1 and NIfTI-2 in one file or two, compressed or not. Positions are millimetres, LPS: those of the sform
/// where it has a code, sheared or not, else of the qform; else voxel sizes along x, y, z, whose sides it does not say.
/// Numbers are those of scl_slope and scl_inter, unless scl_slope is 0. dim[5] counts channels, dim[4], dim[6] and
/// dim[7] volumes.
/// @throw IoError for what is missing, malformed or truncated. @throw InvalidArgument for what cannot be used, and
/// where it holds several channels or volumes and none was chosen.
StoredVolume readNifti(const std::string& path, const VolumeChoice& choice = {}, const ProgressCallback& progress = {});

}  // namespace raysweep
