/// Volumes in the formats of medicine and science, read by ITK: NRRD, MetaImage, NIfTI, DICOM. ITK is loaded at the
/// first call; where it was not there when the library was built, these functions throw.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"

#include <string>
#include <vector>

namespace raysweep {

/// False if this build lacks ITK. Loads it.
bool hasItk();

enum class ItkFormat { nrrd, metaImage, nifti };

/// Reads NRRD (attached or detached header), MetaImage or NIfTI. Positions are as ITK gives them: millimetres where the
/// file says so, patient coordinates LPS (x to the left, y to the back, z to the head) where it has an orientation.
/// Rescaling that the file asks for is done (NIfTI's scl_slope). A volume of two dimensions is one slice.
/// @throw IoError if the file is missing, its header is malformed, or data are missing.
/// @throw InvalidArgument if it has more than three dimensions or more than one number per voxel.
StoredVolume readItkVolume(const std::string& path, ItkFormat format, const ProgressCallback& progress = {});

/// Reads one series of DICOM images (or one multi-frame image), in any order: slices are sorted by their positions
/// along the normal of the first. Values are rescaled (Hounsfield units); positions are LPS, millimetres.
/// @param files DICOM files; those that hold no image are passed over.
/// @param series SeriesInstanceUID of the one to read; may be empty if there is only one.
/// @param positions false: slices are equally spaced by 1 whatever their positions, in the order of their numbers.
/// @throw InvalidArgument if there are several series and `series` names none of them (it lists them), if slices
/// differ in size or orientation, are not equally spaced (it names the place), or have colour.
/// @throw IoError if a file cannot be read, or none holds an image.
StoredVolume readDicomSeries(const std::vector<std::string>& files, const std::string& series, bool positions = true,
                             const ProgressCallback& progress = {});

/// Writes a MetaImage (.mha) of 32 bit floats, i fastest, whole or not at all. `spacing` may be negative: the axis then
/// counts backwards. @throw InvalidArgument if a spacing is 0 or not finite. @throw IoError if it cannot be written.
void writeMetaImage(const std::string& path, const Index3& dims, const float* samples, const Vec3& origin,
                    const Vec3& spacing);

}  // namespace raysweep
