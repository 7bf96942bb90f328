/// Volumes for other programs: dense files, written whole or not at all.
#pragma once

#include "raysweep/formats/dense_source.h"

#include <string>

namespace raysweep {

enum class DenseFormat {
    unknown,
    metaImage,  ///< .mha
    nrrd,       ///< .nrrd
    nifti,      ///< .nii, .nii.gz
    tiffFolder  ///< a folder of .tif slices
};

/// For messages.
constexpr const char* kDenseEndings = ".mha, .nrrd, .nii, .nii.gz, or a folder for .tif slices";

/// By the ending of a name, whatever its case. A name without one stands for a folder, and so does one that ends in a
/// slash or is that of a folder, unless the ending is of a file of volumes.
DenseFormat denseFormat(const std::string& path);

/// Checks that `path` could be written, so that long work does not end in an error that was certain at its start.
/// A folder that is there must hold nothing but slices that were written so.
/// @throw IoError as requireWritable and OutputFolder do
void requireDenseOutput(const std::string& path);

/// Writes 32 bit floats, one sample per voxel, with their place: MetaImage, NRRD, NIfTI-1, or TIFF slices 0 to
/// dims.z - 1 (slice_0000.tif ...), row j = 0 on top. World coordinates are taken for a patient's, LPS, so that
/// importVolume finds the voxels where they were: to rounding, in NIfTI to that of single precision.
/// @throw InvalidArgument if the format cannot say where the volume is (see dense_headers.h), or a voxel is not finite
/// @throw IoError if the format is not known, there is not enough room, or the file cannot be written
void writeDense(const std::string& path, DenseSource& source);

}  // namespace raysweep
