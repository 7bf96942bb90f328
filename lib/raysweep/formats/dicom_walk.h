/// The bare structure of a DICOM file, seen before any library reads it. For dicom_header.cpp.
#pragma once

#include <cstdint>
#include <string>

namespace raysweep {

/// Where the pixels of a file are, if it has any.
struct DicomStructure {
    bool pixels = false;           ///< there is an element of pixels
    bool packed = false;           ///< in fragments, compressed
    std::uint64_t pixelBytes = 0;  ///< where they are not packed
    std::uint64_t fragments = 0;   ///< where they are; the table of their places is none
    std::uint64_t end = 0;         ///< of the data set, bytes from the start of the file
    bool trailing = false;         ///< behind that there are zeros, and maybe more
};

/// Steps from element to element to the end of the file: what it takes is bounded by the file's size and by a million
/// elements, while DCMTK and GDCM need memory and time without end for elements that are nothing but zeros. Zeros
/// behind the pixels are taken for the file's end: media are filled up with them.
/// @throw IoError if the file is not DICOM, is malformed or ends early, or is deflated as a whole
DicomStructure walkDicom(const std::string& file);

}  // namespace raysweep
