/// Pixels of DICOM files, as they are stored. For the module that reads DICOM.
#pragma once

#include "raysweep/formats/dicom_header.h"
#include "raysweep/formats/stored_volume.h"

namespace raysweep {

/// The type that holds the stored bits.
SampleType storedType(const DicomPixels& pixels);

/// All frames of the header's file, one behind the other: the stored bits of `channel` as numbers, not rescaled, not
/// inverted; bits beside them (overlays) are left out. @throw IoError if they cannot be unpacked @throw InvalidArgument
/// if there is not enough memory
StoredVolume readDicomPixels(const DicomHeader& header, int channel);

}  // namespace raysweep
