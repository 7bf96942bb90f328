/// Volumes of pictures.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/formats/volume_choice.h"

#include <string>
#include <vector>

namespace raysweep {

/// Pictures (TIFF, PNG ...) in the order of `files`, each a slice; all pages of those that have several. Where ImageJ
/// or OME-XML say which pages are slices, channels and frames, and how far apart, that counts. Parts of an EXR are
/// volumes. Numbers are those stored: of 12 bits, 0 to 4095.
/// @throw InvalidArgument naming the file, and the page, whose size or type differs from the first; and where there are
/// several channels or volumes and none is chosen.
/// @throw IoError if a file is missing, is not a picture, or ends early.
StoredVolume readPictures(const std::vector<std::string>& files, const VolumeChoice& choice = {},
                          const ProgressCallback& progress = {});

}  // namespace raysweep
