/// What kind of volume some files hold, and reading it.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/formats/volume_choice.h"

#include <string>
#include <vector>

namespace raysweep {

/// What is asked of files beyond what they hold.
struct VolumeRequest {
    std::string series;     ///< SeriesInstanceUID, for DICOM: see readDicomSeries
    bool positions = true;  ///< false: DICOM slices are equally spaced by 1, whatever their positions
    VolumeChoice choice;
};

/// Files, or one folder, as importVolume takes them, without raw ones. @throw as importVolume does.
StoredVolume readVolumeFiles(const std::vector<std::string>& files, const VolumeRequest& request = {},
                             const ProgressCallback& progress = {});

}  // namespace raysweep
