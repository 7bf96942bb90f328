// Source: DICOM PS3.3, C.7.6.16 (multi-frame functional groups), C.8.8.3 (RT Dose).
#include "raysweep/formats/dicom_frames.h"

#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <dcmtk/config/osconfig.h>  // must come first

#include <dcmtk/dcmdata/dctk.h>

#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

namespace raysweep {
namespace {

/// Where an attribute of a frame is to be looked for: an item of its own group sequence, or the file itself.
class FrameData {
  public:
    /// @param own item of the sequence of the frames' own groups; null if there is none
    FrameData(DcmDataset& data, DcmItem* own) : data_(data), own_(own) {
        DcmItem* item = nullptr;
        if (data.findAndGetSequenceItem(DCM_SharedFunctionalGroupsSequence, item).good()) shared_ = item;
    }

    /// The element `tag` in the functional group `group`, else on top.
    std::string text(const DcmTagKey& group, const DcmTagKey& tag) {
        DcmItem* const item = itemWith(group, tag);
        return item ? dicomText(*item, tag) : "";
    }
    std::vector<double> numbers(const DcmTagKey& group, const DcmTagKey& tag, const std::string& file) {
        DcmItem* const item = itemWith(group, tag);
        return item ? dicomNumbers(*item, tag, file) : std::vector<double>();
    }

  private:
    DcmItem* itemWith(const DcmTagKey& group, const DcmTagKey& tag) {
        for (DcmItem* const groups : {own_, shared_}) {
            DcmItem* item = nullptr;
            if (groups && groups->findAndGetSequenceItem(group, item).good() && item->tagExistsWithValue(tag))
                return item;
        }
        return data_.tagExistsWithValue(tag) ? &data_ : nullptr;
    }

    DcmDataset& data_;
    DcmItem *own_ = nullptr, *shared_ = nullptr;
};

/// Slope and intercept of one frame; of doses, the size of their unit.
Rescaling rescalingOf(FrameData& frame, const std::string& file) {
    const auto slope = frame.numbers(DCM_PixelValueTransformationSequence, DCM_RescaleSlope, file);
    const auto intercept = frame.numbers(DCM_PixelValueTransformationSequence, DCM_RescaleIntercept, file);
    const auto dose = frame.numbers(DCM_PixelValueTransformationSequence, DCM_DoseGridScaling, file);
    Rescaling rescaling;
    if (!dose.empty()) rescaling.slope = dose[0];
    if (!slope.empty()) rescaling.slope = slope[0];
    if (!intercept.empty()) rescaling.intercept = intercept[0];
    if (rescaling.slope == 0) failRead(file, "in its header: its slope is 0, which makes all numbers the same");
    return rescaling;
}

void placeFrame(FrameData& data, const std::string& file, DicomFrame& frame) {
    auto spacing = data.numbers(DCM_PixelMeasuresSequence, DCM_PixelSpacing, file);
    for (const DcmTagKey& tag : {DCM_ImagerPixelSpacing, DCM_NominalScannedPixelSpacing})
        if (spacing.size() != 2) spacing = data.numbers(DCM_PixelMeasuresSequence, tag, file);
    if (spacing.size() == 2) {
        if (!(spacing[0] > 0 && spacing[1] > 0)) failRead(file, "in its header: its pixel spacing is not positive");
        frame.rowSpacing = spacing[0];
        frame.columnSpacing = spacing[1];
    }
    const auto position = data.numbers(DCM_PlanePositionSequence, DCM_ImagePositionPatient, file);
    const auto axes = data.numbers(DCM_PlaneOrientationSequence, DCM_ImageOrientationPatient, file);
    if (position.size() != 3 || axes.size() != 6) return;
    const Vec3 row(axes[0], axes[1], axes[2]), column(axes[3], axes[4], axes[5]);
    constexpr double kRounding = 0.01;  // of directions that are written with few digits
    if (!(std::abs(row.length() - 1) < kRounding && std::abs(column.length() - 1) < kRounding &&
          std::abs(row.dot(column)) < kRounding))
        failRead(file, "in its header: its rows and columns are not at right angles, or not of length 1");
    frame.position = Vec3(position[0], position[1], position[2]);
    frame.axes = axes;
}

void addTraits(FrameData& data, DicomFrame& frame) {
    const struct {
        const char* name;
        DcmTagKey group, tag;
    } kTraits[] = {{"echo", DCM_MREchoSequence, DCM_EchoNumbers},
                   {"effective echo time", DCM_MREchoSequence, DCM_EffectiveEchoTime},
                   {"echo time", DCM_MREchoSequence, DCM_EchoTime},
                   {"instant", DCM_FrameContentSequence, DCM_TemporalPositionIndex},
                   {"temporal position", DCM_TemporalPositionSequence, DCM_TemporalPositionIdentifier},
                   {"trigger time", DCM_CardiacSynchronizationSequence, DCM_TriggerTime},
                   {"b value", DCM_MRDiffusionSequence, DCM_DiffusionBValue},
                   {"acquisition", DCM_FrameContentSequence, DCM_AcquisitionNumber},
                   {"frame acquisition", DCM_FrameContentSequence, DCM_FrameAcquisitionNumber},
                   {"stack", DCM_FrameContentSequence, DCM_StackID},
                   {"frame type", DCM_MRImageFrameTypeSequence, DCM_FrameType},
                   {"image type", DCM_FrameContentSequence, DCM_ImageType},
                   {"acquisition time", DCM_FrameContentSequence, DCM_AcquisitionTime}};
    std::map<std::string, std::string> traits;
    for (const auto& trait : kTraits) traits[trait.name] = data.text(trait.group, trait.tag);
    frame.traits = std::make_shared<const std::map<std::string, std::string>>(std::move(traits));
}

DicomFrame frameOf(FrameData data, const std::string& file, double number) {
    DicomFrame frame;
    frame.file = file;
    frame.number = number;
    frame.rescaling = rescalingOf(data, file);
    placeFrame(data, file, frame);
    addTraits(data, frame);
    return frame;
}

/// The items of the frames' own groups, one after the other: to look for each from the first takes ages.
class OwnGroups {
  public:
    explicit OwnGroups(DcmDataset& data) {
        data.findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, items_);
        more_ = items_ != nullptr;
    }

    /// @return null if there are no more
    DcmItem* next() {
        if (more_) at_ = items_->nextInContainer(at_);
        more_ = more_ && at_;
        return more_ ? dynamic_cast<DcmItem*>(at_) : nullptr;
    }

  private:
    DcmSequenceOfItems* items_ = nullptr;
    DcmObject* at_ = nullptr;
    bool more_ = false;
};

/// Frames that have one position together: their distances from it are in a list, or all the same.
void spread(DcmDataset& data, const std::string& file, std::vector<DicomFrame>& frames) {
    const Vec3 first = frames.front().position;
    for (const DicomFrame& frame : frames)
        if (frame.axes.empty() || (frame.position - first).length() > 0) return;
    if (data.tagExists(DCM_PerFrameFunctionalGroupsSequence)) return;
    const std::vector<double>& axes = frames.front().axes;
    const Vec3 normal = Vec3(axes[0], axes[1], axes[2]).cross(Vec3(axes[3], axes[4], axes[5]));
    auto offsets = dicomNumbers(data, DCM_GridFrameOffsetVector, file);
    const auto spacing = dicomNumbers(data, DCM_SpacingBetweenSlices, file);
    if (offsets.empty() && !spacing.empty() && spacing[0] != 0)
        for (std::size_t n = 0; n < frames.size(); ++n) offsets.push_back(double(n) * spacing[0]);
    for (std::size_t n = 0; n < frames.size(); ++n)
        if (offsets.size() == frames.size())
            frames[n].position += normal * (offsets[n] - offsets[0]);
        else
            frames[n].axes.clear();  // it does not say where it is
}

}  // namespace

std::string dicomText(DcmItem& data, const DcmTagKey& tag) {
    OFString value;
    return data.findAndGetOFStringArray(tag, value).good() ? std::string(value.c_str()) : std::string();
}

std::vector<double> dicomNumbers(DcmItem& data, const DcmTagKey& tag, const std::string& file) {
    std::istringstream parts(dicomText(data, tag));
    std::vector<double> numbers;
    for (std::string part; std::getline(parts, part, '\\');) {
        double number = 0;
        if (trimmed(part).empty()) continue;
        if (!toNumber(trimmed(part), number) || !std::isfinite(number))
            failRead(file, "in its header: " + std::string(DcmTag(tag).getTagName()) + " '" + part.substr(0, 60) +
                               "' is no number");
        numbers.push_back(number);
    }
    return numbers;
}

std::vector<DicomFrame> dicomFrames(DcmDataset& data, const std::string& file, int count) {
    constexpr int kMost = 1 << 20;
    if (count > kMost) failRead(file, "in its header: it promises more frames than there can be");
    const auto numbers = dicomNumbers(data, DCM_InstanceNumber, file);
    const double number = numbers.empty() ? 0 : numbers[0];
    std::vector<DicomFrame> frames;
    frames.reserve(std::size_t(count));
    OwnGroups groups(data);
    std::optional<DicomFrame> common;  // of the frames without groups of their own
    for (int index = 0; index < count; ++index) {
        DcmItem* const own = groups.next();
        if (!own && !common) common = frameOf(FrameData(data, nullptr), file, number);
        frames.push_back(own ? frameOf(FrameData(data, own), file, number) : *common);
        DicomFrame& frame = frames.back();
        frame.index = index;
        if (index > 0 && *frame.traits == *frames[frames.size() - 2].traits)
            frame.traits = frames[frames.size() - 2].traits;
    }
    if (count > 1) spread(data, file, frames);
    return frames;
}

}  // namespace raysweep
