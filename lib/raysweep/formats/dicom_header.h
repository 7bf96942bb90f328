/// What the headers of DICOM files say. Nothing but itk_dicom.cpp includes it.
#pragma once

#include "raysweep/core/types.h"

#include <string>
#include <vector>

namespace raysweep {

struct DicomHeader {
    std::string file;
    bool image = false;               ///< it holds pixels; reports, presentation states and the like do not
    std::string series, description;  ///< SeriesInstanceUID, SeriesDescription
    Vec3 position{0};                 ///< of its first pixel, mm, LPS
    std::vector<double> axes;         ///< directions of rows and columns, six numbers; none: it does not say its place
    double number = 0;                ///< InstanceNumber
    std::string coding;               ///< all that decides which type its rescaled values have
};

/// @throw IoError if the file is not DICOM, is malformed, or ends early, also if that is in its pixels.
/// @throw InvalidArgument if it is an image in colour.
DicomHeader readDicomHeader(const std::string& file);

}  // namespace raysweep
