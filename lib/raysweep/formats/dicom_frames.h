/// The pictures of one DICOM file: where they are, what their numbers mean. For dicom_header.cpp.
#pragma once

#include "raysweep/formats/dicom_header.h"

#include <string>
#include <vector>

class DcmDataset;
class DcmItem;
class DcmTagKey;

namespace raysweep {

/// All values of an element, separated by backslashes; empty if there is none.
std::string dicomText(DcmItem& data, const DcmTagKey& tag);
/// The same as numbers. @throw IoError if one is none
std::vector<double> dicomNumbers(DcmItem& data, const DcmTagKey& tag, const std::string& file);

/// `count` frames, in their order. A frame's own functional groups count before those that all share, those before what
/// the file says on top. @throw IoError for what is malformed
std::vector<DicomFrame> dicomFrames(DcmDataset& data, const std::string& file, int count);

}  // namespace raysweep
