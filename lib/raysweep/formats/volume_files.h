/// What kind of volume some files hold, and reading it.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"

#include <string>
#include <vector>

namespace raysweep {

/// Files, or one folder, as importVolume takes them, without raw ones. `series` and `positions` are for DICOM: see
/// readDicomSeries. @throw as importVolume does.
StoredVolume readVolumeFiles(const std::vector<std::string>& files, const std::string& series, bool positions,
                             const ProgressCallback& progress = {});

}  // namespace raysweep
