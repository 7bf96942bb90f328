// What belongs together, and in what order, is decided by the headers; every slice is unpacked, and its stored numbers
// rescaled, on its own.
#include "raysweep/core/error.h"
#include "raysweep/core/memory.h"
#include "raysweep/formats/dicom_header.h"
#include "raysweep/formats/dicom_pixels.h"
#include "raysweep/formats/dicom_volumes.h"
#include "raysweep/formats/itk_formats.h"
#include "raysweep/formats/read_failure.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <map>
#include <set>
#include <utility>

namespace raysweep {
namespace {

using Series = std::map<std::string, std::vector<DicomHeader>>;  ///< images by SeriesInstanceUID

Series seriesOf(const std::vector<std::string>& files, const ProgressCallback& progress, bool& complete) {
    Series series;
    for (std::size_t n = 0; n < files.size(); ++n) {
        complete = report(progress, "headers", double(n) / double(files.size()));
        if (!complete) return series;
        DicomHeader header = readDicomHeader(files[n]);
        if (!header.image) continue;
        std::vector<DicomHeader>& images = series[header.series];
        images.push_back(std::move(header));
    }
    return series;
}

std::string listOf(const Series& series) {
    std::string list;
    for (const auto& [uid, images] : series) {
        const std::string& description = images.front().description;
        list += "\n  " + uid + "  " + std::to_string(images.size()) + " image" + (images.size() > 1 ? "s" : "") +
                (description.empty() ? "" : "  " + description);
    }
    return list;
}

bool cannotBeUsed(const DicomHeader& image) {
    return image.problem != nullptr;
}

std::string messageOf(const std::exception_ptr& problem) {
    try {
        std::rethrow_exception(problem);
    } catch (const Error& error) {
        return error.what();
    }
}

/// Takes out those of which no image can be used (reports, masks beside scans), unless there are no others.
/// @return notes of what they were
std::vector<std::string> leaveOutUseless(Series& series) {
    Series useful;
    std::vector<std::string> notes;
    for (auto& [uid, images] : series) {
        const DicomHeader& first = images.front();
        if (std::all_of(images.begin(), images.end(), cannotBeUsed))
            notes.push_back("series " + uid + " (" + std::to_string(images.size()) +
                            (images.size() > 1 ? " images" : " image") + ") was left out: " + messageOf(first.problem));
        else
            useful[uid] = std::move(images);
    }
    if (useful.empty()) return {};
    series = std::move(useful);
    return notes;
}

/// @param notes are added to. @throw what is wrong with an image of the series that is chosen
std::vector<DicomHeader> choose(Series series, const std::string& uid, std::vector<std::string>& notes) {
    if (!uid.empty() && series.count(uid) == 0)
        throw InvalidArgument("there is no DICOM series '" + uid + "'; there are:" + listOf(series));
    if (uid.empty()) notes = leaveOutUseless(series);
    std::vector<DicomHeader>& chosen = uid.empty() ? series.begin()->second : series.at(uid);
    if (uid.empty() && series.size() > 1 && !std::all_of(chosen.begin(), chosen.end(), cannotBeUsed))
        throw InvalidArgument("there are " + std::to_string(series.size()) + " DICOM series; choose one",
                              Remedy::chooseSeries, ":" + listOf(series));
    const auto bad = std::find_if(chosen.begin(), chosen.end(), cannotBeUsed);
    if (bad != chosen.end()) std::rethrow_exception(bad->problem);
    return std::move(chosen);
}

/// All must have one size and one meaning.
void requireAlike(const std::vector<DicomHeader>& images) {
    const DicomPixels& first = images.front().pixels;
    const auto size = [](const DicomPixels& p) { return std::to_string(p.columns) + "x" + std::to_string(p.rows); };
    for (const DicomHeader& image : images) {
        const DicomPixels& pixels = image.pixels;
        if (pixels.columns != first.columns || pixels.rows != first.rows)
            throw InvalidArgument("the size of '" + image.file + "' is " + size(pixels) + ", but that of '" +
                                  images.front().file + "' " + size(first));
        if (pixels.photometric != first.photometric || pixels.channels != first.channels)
            throw InvalidArgument("'" + image.file + "' is " + pixels.photometric + ", but '" + images.front().file +
                                  "' is " + first.photometric);
    }
}

int channelOf(const DicomHeader& image, const VolumeChoice& choice) {
    static const char* const kNames[] = {"red", "green", "blue", "?"};
    Several channels{std::uint64_t(image.pixels.channels), "channels (" + image.pixels.photometric + ")", {}};
    if (channels.count > 1) channels.name = [](int n) { return std::string(kNames[n]); };
    return chooseChannel(image.file, channels, choice);
}

/// The type of all slices together: that of the first where all are coded alike, else floats.
SampleType commonType(const std::vector<DicomHeader>& images, const std::vector<DicomFrame>& slices) {
    const SampleType first = storedType(images.front().pixels);
    bool alike = true;
    for (const DicomHeader& image : images) alike = alike && storedType(image.pixels) == first;
    for (const DicomFrame& slice : slices)
        alike = alike && slice.rescaling.slope == slices.front().rescaling.slope &&
                slice.rescaling.intercept == slices.front().rescaling.intercept;
    if (alike) return rescaledType(first, slices.front().rescaling);
    return sizeOf(first) < 4 ? SampleType::float32 : SampleType::float64;
}

/// Samples of `slice` that stand for pixels which were not measured.
std::uint64_t countPadding(const DicomPixels& pixels, SampleType type, std::uint64_t count, const std::byte* slice) {
    if (!pixels.padding) return 0;
    const auto [low, high] = std::minmax(*pixels.padding, pixels.paddingLimit);
    return withSampleType(type, [&, low = low, high = high](auto zero) {
        const auto* const samples = reinterpret_cast<const decltype(zero)*>(slice);
        return std::uint64_t(std::count_if(samples, samples + count, [&](auto sample) {
            return double(sample) >= double(low) && double(sample) <= double(high);
        }));
    });
}

/// Reads one file after the other, those of several slices once.
class SliceReader {
  public:
    SliceReader(const std::vector<DicomHeader>& images, int channel) : channel_(channel) {
        for (const DicomHeader& image : images) images_[image.file] = &image;
    }

    /// Numbers of `slice`, of the type of `volume`.
    void read(const DicomFrame& slice, StoredVolume& volume, std::byte* to) {
        const DicomHeader& header = *images_.at(slice.file);
        if (slice.file != file_) {
            image_ = StoredVolume();  // so that two are never held
            image_ = readDicomPixels(header, channel_);
            file_ = slice.file;
        }
        const std::uint64_t count = std::uint64_t(image_.dims.x) * std::uint64_t(image_.dims.y);
        const std::byte* const from = image_.samples.get() + std::uint64_t(slice.index) * count * sizeOf(image_.type);
        padded_ += countPadding(header.pixels, image_.type, count, from);
        rescaleInto(from, image_.type, count, slice.rescaling, volume.type, to);
    }

    std::uint64_t padded() const { return padded_; }

  private:
    int channel_;
    std::map<std::string, const DicomHeader*> images_;
    std::string file_;
    StoredVolume image_;
    std::uint64_t padded_ = 0;
};

/// Where the slices are, by the first of them and the way to the last.
void placeVolume(const std::vector<DicomFrame>& slices, bool positions, StoredVolume& volume) {
    const DicomFrame& first = slices.front();
    volume.steps = {Vec3(first.columnSpacing, 0, 0), Vec3(0, first.rowSpacing, 0), Vec3(0, 0, 1)};
    if (!first.axes.empty()) {
        const Vec3 row(first.axes[0], first.axes[1], first.axes[2]),
            column(first.axes[3], first.axes[4], first.axes[5]);
        volume.steps = {row * first.columnSpacing, column * first.rowSpacing, row.cross(column)};
        volume.origin = first.position;
    }
    if (positions && slices.size() > 1) volume.steps[2] = stepOf(slices);
    for (const DicomFrame& slice : slices)
        if (std::abs(slice.columnSpacing / first.columnSpacing - 1) > 1e-3 ||
            std::abs(slice.rowSpacing / first.rowSpacing - 1) > 1e-3)
            throw InvalidArgument("'" + slice.file + "' and '" + first.file + "' have pixels of different sizes");
}

/// The slices of the volume that is meant, in order. Takes the frames of `images`, which may be a million.
std::vector<DicomFrame> slicesOf(std::vector<DicomHeader>& images, bool positions, const VolumeChoice& choice) {
    std::size_t count = 0;
    for (const DicomHeader& image : images) count += image.frames.size();
    std::vector<DicomFrame> slices;
    slices.reserve(count);
    for (DicomHeader& image : images) {
        std::move(image.frames.begin(), image.frames.end(), std::back_inserter(slices));
        image.frames = std::vector<DicomFrame>();
    }
    const bool placed = std::none_of(slices.begin(), slices.end(), [](const auto& s) { return s.axes.empty(); });
    if (slices.size() > 1 && (positions || placed)) {
        sortByPosition(slices);
        slices = chooseFrames(std::move(slices), choice);
    } else {
        chooseVolume(slices.front().file, {}, choice);
    }
    if (!positions) sortByNumber(slices);
    return slices;
}

void addNotes(const std::vector<DicomHeader>& images, std::uint64_t padded, StoredVolume& volume) {
    std::set<std::string> notes;
    for (const DicomHeader& image : images) notes.insert(image.notes.begin(), image.notes.end());
    volume.notes.insert(volume.notes.end(), notes.begin(), notes.end());
    if (padded > 0)
        volume.notes.push_back(std::to_string(padded) + " voxels hold its padding (" +
                               std::to_string(images.front().pixels.padding.value_or(0)) +
                               " as stored, for what was not measured), and were taken as numbers like others");
}

}  // namespace

StoredVolume itkSeries(const std::vector<std::string>& files, const SeriesRequest& request,
                       const ProgressCallback& progress) {
    StoredVolume volume;
    Series all = seriesOf(files, progress, volume.complete);
    if (!volume.complete) return volume;
    if (all.empty()) failRead(files.front(), "there is no DICOM image in it");
    std::vector<DicomHeader> images = choose(std::move(all), request.series, volume.notes);
    requireAlike(images);
    const int channel = channelOf(images.front(), request.choice);
    const std::vector<DicomFrame> slices = slicesOf(images, request.positions, request.choice);

    volume.dims = Index3(images.front().pixels.columns, images.front().pixels.rows, int(slices.size()));
    volume.type = commonType(images, slices);
    placeVolume(slices, request.positions, volume);
    const std::uint64_t sliceBytes = volume.count() / slices.size() * sizeOf(volume.type);
    requireBytes(double(sliceBytes) * double(slices.size()), "'" + files.front() + "': the series alone needs",
                 "crop or resample it elsewhere first");
    volume.samples.reset(new std::byte[sliceBytes * slices.size()]);
    SliceReader reader(images, channel);
    for (std::size_t n = 0; n < slices.size(); ++n) {
        volume.complete = report(progress, "reading", double(n) / double(slices.size()));
        if (!volume.complete) return volume;
        reader.read(slices[n], volume, volume.samples.get() + n * sliceBytes);
    }
    addNotes(images, reader.padded(), volume);
    volume.format = "DICOM";
    volume.unit = "mm";
    volume.calibrated = true;
    return volume;
}

}  // namespace raysweep
