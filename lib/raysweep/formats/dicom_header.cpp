// DCMTK, not GDCM, which reads the pixels later: GDCM takes a file that ends early for a good one, and meets some
// malformed headers with a failed assertion, which ends the program. DCMTK finds both.
#include "raysweep/formats/dicom_header.h"

#include "raysweep/core/claimed_room.h"
#include "raysweep/core/error.h"
#include "raysweep/formats/dicom_frames.h"
#include "raysweep/formats/dicom_walk.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <dcmtk/config/osconfig.h>  // must come first

#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/oflog/oflog.h>

#include <cstdint>

namespace raysweep {
namespace {

int wholeOf(DcmItem& data, const DcmTagKey& tag, int otherwise, const std::string& file) {
    const std::string text = dicomText(data, tag);
    if (text.empty()) return otherwise;
    const std::vector<double> numbers = dicomNumbers(data, tag, file);
    if (numbers.empty() || !(numbers[0] >= 0 && numbers[0] <= 1e9))
        failRead(file, "in its header: " + std::string(DcmTag(tag).getTagName()) + " '" + text.substr(0, 60) +
                           "' makes no sense");
    return int(numbers[0]);
}

DicomPixels pixelsOf(DcmDataset& data, const std::string& file) {
    const auto whole = [&](const DcmTagKey& tag, int otherwise) { return wholeOf(data, tag, otherwise, file); };
    DicomPixels pixels;
    pixels.columns = whole(DCM_Columns, 0);
    pixels.rows = whole(DCM_Rows, 0);
    pixels.frames = whole(DCM_NumberOfFrames, 1);
    pixels.channels = whole(DCM_SamplesPerPixel, 1);
    pixels.bitsAllocated = whole(DCM_BitsAllocated, 0);
    pixels.bitsStored = whole(DCM_BitsStored, pixels.bitsAllocated);
    pixels.highBit = whole(DCM_HighBit, pixels.bitsStored - 1);
    pixels.isSigned = whole(DCM_PixelRepresentation, 0) == 1;
    pixels.photometric = dicomText(data, DCM_PhotometricInterpretation);
    while (!pixels.photometric.empty() && pixels.photometric.back() == ' ') pixels.photometric.pop_back();
    const auto padding = dicomNumbers(data, DCM_PixelPaddingValue, file);
    const auto limit = dicomNumbers(data, DCM_PixelPaddingRangeLimit, file);
    if (!padding.empty()) {
        pixels.padding = std::int64_t(padding[0]);
        pixels.paddingLimit = limit.empty() ? *pixels.padding : std::int64_t(limit[0]);
    }
    return pixels;
}

/// What there is room for: pixels that are not compressed tell how many bytes they have.
void requireSound(const DicomStructure& structure, const DicomPixels& pixels, const std::string& file) {
    const auto fail = [&](const std::string& why) { failRead(file, "in its header: " + why); };
    if (pixels.columns < 1 || pixels.rows < 1 || pixels.frames < 1 || pixels.channels < 1 || pixels.channels > 4)
        fail("it promises no pixels");
    if (pixels.bitsAllocated != 8 && pixels.bitsAllocated != 16 && pixels.bitsAllocated != 32)
        throw InvalidArgument("'" + file + "' has pixels of " + std::to_string(pixels.bitsAllocated) +
                              " bits, which cannot be read; convert them to 8, 16 or 32 bits");
    if (pixels.bitsStored < 1 || pixels.highBit >= pixels.bitsAllocated || pixels.highBit < pixels.bitsStored - 1)
        fail("bits allocated, bits stored and the high bit contradict each other");
    const double needed =
        double(pixels.columns) * pixels.rows * pixels.frames * pixels.channels * (pixels.bitsAllocated / 8);
    if (structure.packed) requireRoom(file, needed, double(sizeOfFile(file)));
    if (structure.packed && std::uint64_t(pixels.frames) > structure.fragments)  // each has one at least
        failRead(file, "its pixels end early: it promises " + std::to_string(pixels.frames) + " frames, there are " +
                           std::to_string(structure.fragments) + " fragments of pixels");
    if (!structure.packed && double(structure.pixelBytes) < needed)
        failRead(file, "its pixels end early: " + std::to_string(std::uint64_t(needed)) +
                           " bytes are needed, there are " + std::to_string(structure.pixelBytes));
}

/// What would make other numbers of the pixels.
void requireNumbers(DcmDataset& data, const DicomPixels& pixels, const std::string& file) {
    const auto refuse = [&](const std::string& why) { throw InvalidArgument("'" + file + "' " + why); };
    const bool grey = pixels.photometric == "MONOCHROME1" || pixels.photometric == "MONOCHROME2";
    if (pixels.channels == 1 && !grey && !pixels.photometric.empty())
        refuse("has pixels that are " + pixels.photometric.substr(0, 20) +
               ", not numbers that were measured; convert it to MONOCHROME2");
    if (pixels.channels > 1 && pixels.photometric != "RGB")
        refuse("is in colour (" + pixels.photometric.substr(0, 20) + "); convert it to RGB, or to MONOCHROME2");
    if (dicomText(data, DCM_ImageType).find("MOSAIC") != std::string::npos)
        refuse("is a mosaic: one picture with all slices side by side; convert it to NIfTI, or to a picture per slice");
    if (data.tagExists(DCM_ModalityLUTSequence))
        refuse("has a table (Modality LUT) that makes numbers of its pixels, which cannot be used; apply it first");
}

bool hasFloats(DcmDataset& data) {
    return data.tagExists(DCM_FloatPixelData) || data.tagExists(DCM_DoubleFloatPixelData);
}

/// @throw what `problem` is to be
void addImage(DcmDataset& data, const DicomStructure& structure, DicomHeader& header) {
    const std::string& file = header.file;
    if (hasFloats(data))
        throw InvalidArgument("'" + file + "' has pixels that are floats, which cannot be read; convert it to NIfTI");
    header.pixels = pixelsOf(data, file);
    requireSound(structure, header.pixels, file);
    requireNumbers(data, header.pixels, file);
    header.frames = dicomFrames(data, file, header.pixels.frames);
    if (header.pixels.photometric == "MONOCHROME1")
        header.notes.push_back("its large numbers are shown dark (MONOCHROME1); they were taken as they are");
    if (data.tagExists(DCM_RealWorldValueMappingSequence) && header.frames.front().rescaling.isNone())
        header.notes.push_back("it has a mapping to real-world values, which was not applied");
    if (structure.trailing) header.notes.push_back("its data go on behind the pixels; the rest was not read");
}

}  // namespace

DicomHeader readDicomHeader(const std::string& file) {
    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
    const DicomStructure structure = walkDicom(file);
    DcmFileFormat format;
    const OFCondition read = format.loadFileUntilTag(file.c_str(), EXS_Unknown, EGL_noChange, DCM_MaxReadLength,
                                                     ERM_autoDetect, DCM_PixelData);
    if (read.bad()) failRead(file, std::string("it is not DICOM, is malformed, or ends early (") + read.text() + ")");
    DcmDataset& data = *format.getDataset();

    DicomHeader header;
    header.file = file;
    header.series = dicomText(data, DCM_SeriesInstanceUID);
    header.description = dicomText(data, DCM_SeriesDescription);
    header.end = structure.end;
    header.image = hasFloats(data) || (structure.pixels && !dicomText(data, DCM_Rows).empty());
    if (!header.image) return header;
    try {
        addImage(data, structure, header);
    } catch (const Error&) {
        header.problem = std::current_exception();
    }
    return header;
}

}  // namespace raysweep
