/// What the headers of DICOM files say. For the module that reads DICOM.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/formats/rescale.h"

#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// One picture: a file, or a frame of one.
struct DicomFrame {
    std::string file;
    int index = 0;             ///< of the frame in its file
    double number = 0;         ///< InstanceNumber
    Vec3 position{0};          ///< of its first pixel, mm, LPS
    std::vector<double> axes;  ///< directions of rows and columns, six numbers; none: it does not say its place
    double columnSpacing = 1, rowSpacing = 1;  ///< mm, from column to column and from row to row
    Rescaling rescaling;
    /// What tells pictures of one place apart: echo, instant ..., as the header says them; empty where it does not.
    /// Shared by frames that say the same.
    std::shared_ptr<const std::map<std::string, std::string>> traits;
};

/// What is the same for all pixels of a file.
struct DicomPixels {
    int columns = 0, rows = 0, frames = 1, channels = 1;
    int bitsAllocated = 16, bitsStored = 16, highBit = 15;
    bool isSigned = false;
    std::string photometric;              ///< MONOCHROME2, RGB ...
    std::optional<std::int64_t> padding;  ///< PixelPaddingValue, of pixels that were not measured
    std::int64_t paddingLimit = 0;        ///< the other end of its range
};

struct DicomHeader {
    std::string file;
    bool image = false;               ///< it holds pixels; reports, presentation states and the like do not
    std::string series, description;  ///< SeriesInstanceUID, SeriesDescription
    DicomPixels pixels;
    std::vector<DicomFrame> frames;
    std::vector<std::string> notes;
    std::exception_ptr problem;  ///< why its pixels cannot be used: for whoever wants them; then there are no frames
    std::uint64_t end = 0;       ///< of what is to be read of the file, bytes
};

/// `problem` is an IoError if the pixels end early or contradict the header, an InvalidArgument if they are no numbers
/// that can be used: indices into a palette or table, inks, single bits. A folder may hold such files beside a series.
/// @throw IoError if the file is not DICOM, is malformed, or ends early
DicomHeader readDicomHeader(const std::string& file);

}  // namespace raysweep
