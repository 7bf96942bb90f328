/// What stands before the samples in files of dense volumes: 32 bit floats, little endian, i fastest. World coordinates
/// are taken for a patient's, LPS, as the readers do.
#pragma once

#include "raysweep/formats/dense_source.h"

#include <string>

namespace raysweep {

/// MetaImage. Source: Kitware, MetaIO documentation.
/// @throw InvalidArgument if axes are not at right angles, for which it has no words
std::string metaImageHeader(const DenseLayout& layout);

/// NRRD. Source: Teem, Definition of NRRD File Format.
std::string nrrdHeader(const DenseLayout& layout);

/// NIfTI-1: its sform, and its qform where axes are at right angles. Source: nifti1.h.
/// @throw InvalidArgument for more than 32767 voxels along an axis, and where single precision would move a voxel by
/// more than a hundredth of an edge
std::string niftiHeader(const DenseLayout& layout);

/// TIFF, one slice of the volume; its description says where it is, and how far voxels are apart, to ImageJ, too.
/// Source: Adobe, TIFF 6.0.
/// @throw InvalidArgument if a slice has 4 GB or more
std::string tiffHeader(const DenseLayout& layout, int slice);

}  // namespace raysweep
