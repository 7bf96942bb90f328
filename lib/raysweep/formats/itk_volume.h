/// What needs ITK and the libraries that come with it: reading DICOM, writing MetaImage. They are loaded at the first
/// call; where they were not there when the library was built, these functions throw.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"
#include "raysweep/formats/volume_choice.h"

#include <string>
#include <vector>

namespace raysweep {

/// False if this build lacks ITK. Loads it.
bool hasItk();

/// Which images of DICOM files are meant.
struct SeriesRequest {
    std::string series;  ///< SeriesInstanceUID; may be empty if there is only one
    bool positions =
        true;             ///< false: slices are equally spaced by 1 whatever their positions, in order of their numbers
    VolumeChoice choice;  ///< of a colour, and of echoes, instants and the like
};

/// Reads one series of DICOM images, or multi-frame images, in any order: slices are sorted by their positions along
/// the normal of the first. Values are rescaled (Hounsfield units), each slice by its own slope and intercept, and
/// never inverted (MONOCHROME1); positions are LPS, millimetres.
/// @param files DICOM files; those that hold no image are passed over, and so are series of which no image can be used,
/// if there are others and none is chosen: a note says which.
/// @throw InvalidArgument if there are several series or volumes and none is chosen (it lists them), if slices differ
/// in size or orientation, are not equally spaced (it names the place), or if pixels are no numbers (palettes, tables).
/// @throw IoError if a file cannot be read, or none holds an image.
StoredVolume readDicomSeries(const std::vector<std::string>& files, const SeriesRequest& request = {},
                             const ProgressCallback& progress = {});

/// Writes a MetaImage (.mha) of 32 bit floats, i fastest, whole or not at all. `spacing` may be negative: the axis then
/// counts backwards. @throw InvalidArgument if a spacing is 0 or not finite. @throw IoError if it cannot be written.
void writeMetaImage(const std::string& path, const Index3& dims, const float* samples, const Vec3& origin,
                    const Vec3& spacing);

}  // namespace raysweep
