// DCMTK, not GDCM, which reads the pixels later: GDCM takes a file that ends early for a good one, and meets some
// malformed headers with a failed assertion, which ends the program. DCMTK finds both.
#include "raysweep/formats/dicom_header.h"

#include "raysweep/core/error.h"

#include <dcmtk/config/osconfig.h>  // must come first

#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/oflog/oflog.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace raysweep {
namespace {

std::string textOf(DcmDataset& data, const DcmTagKey& tag) {
    OFString value;
    return data.findAndGetOFStringArray(tag, value).good() ? std::string(value.c_str()) : std::string();
}

/// Numbers separated by backslashes.
std::vector<double> numbersOf(const std::string& text) {
    std::istringstream parts(text);
    std::vector<double> numbers;
    for (std::string part; std::getline(parts, part, '\\');) numbers.push_back(std::strtod(part.c_str(), nullptr));
    return numbers;
}

/// The first part of a file, its meta information, has elements of group 2 one after the other. DCMTK forgives what is
/// wrong with them, GDCM does not.
bool hasSoundMeta(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    in.seekg(132);
    for (std::uint16_t tag[2]; in.read(reinterpret_cast<char*>(tag), 4) && tag[0] == 2;) {
        char type[3] = {};
        in.read(type, 2);
        const DcmVR vr(type);
        if (!in || !vr.isStandard()) return false;
        std::uint32_t length = 0;
        if (vr.usesExtendedLengthEncoding()) in.ignore(2);
        in.read(reinterpret_cast<char*>(&length), vr.usesExtendedLengthEncoding() ? 4 : 2);
        if (length > 1 << 16) return false;
        in.ignore(length);
    }
    return bool(in);
}

}  // namespace

DicomHeader readDicomHeader(const std::string& file) {
    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
    DcmFileFormat format;
    const OFCondition read = format.loadFile(file.c_str());
    if (read.bad() || !hasSoundMeta(file))
        throw IoError("cannot read '" + file + "': it is not DICOM, is malformed, or ends early" +
                      (read.bad() ? std::string(" (") + read.text() + ")" : ""));
    DcmDataset& data = *format.getDataset();

    DicomHeader header;
    header.file = file;
    header.image = !textOf(data, DCM_Rows).empty() && data.tagExists(DCM_PixelData);
    if (header.image && std::atoi(textOf(data, DCM_SamplesPerPixel).c_str()) > 1)
        throw InvalidArgument("'" + file + "' is in colour (" + textOf(data, DCM_SamplesPerPixel) +
                              " samples per pixel), but a volume needs one number per voxel");
    header.series = textOf(data, DCM_SeriesInstanceUID);
    header.description = textOf(data, DCM_SeriesDescription);
    header.number = std::strtod(textOf(data, DCM_InstanceNumber).c_str(), nullptr);
    const std::vector<double> position = numbersOf(textOf(data, DCM_ImagePositionPatient));
    const std::vector<double> axes = numbersOf(textOf(data, DCM_ImageOrientationPatient));
    if (position.size() == 3 && axes.size() == 6) {
        header.position = Vec3(position[0], position[1], position[2]);
        header.axes = axes;
    }
    for (const DcmTagKey& tag : {DCM_RescaleSlope, DCM_RescaleIntercept, DCM_BitsAllocated, DCM_PixelRepresentation})
        header.coding += textOf(data, tag) + "/";
    return header;
}

}  // namespace raysweep
