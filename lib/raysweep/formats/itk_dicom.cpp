// DICOM through ITK's reader of single images, which rescales and decompresses. What belongs together, and in what
// order, is decided here by the headers.
#include "raysweep/core/error.h"
#include "raysweep/core/natural_order.h"
#include "raysweep/formats/dicom_header.h"
#include "raysweep/formats/itk_formats.h"
#include "raysweep/formats/itk_read.h"

#include <itkGDCMImageIO.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>

namespace raysweep {
namespace {

using Series = std::map<std::string, std::vector<DicomHeader>>;  ///< images by SeriesInstanceUID

std::string number(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

Series seriesOf(const std::vector<std::string>& files, const ProgressCallback& progress, bool& complete) {
    Series series;
    for (std::size_t n = 0; n < files.size(); ++n) {
        complete = report(progress, "headers", double(n) / double(files.size()));
        if (!complete) return series;
        const DicomHeader header = readDicomHeader(files[n]);
        if (header.image) series[header.series].push_back(header);
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

const std::vector<DicomHeader>& choose(const Series& series, const std::string& uid) {
    if (!uid.empty()) {
        const auto found = series.find(uid);
        if (found == series.end())
            throw InvalidArgument("there is no DICOM series '" + uid + "'; there are:" + listOf(series));
        return found->second;
    }
    if (series.size() > 1)
        throw InvalidArgument("there are " + std::to_string(series.size()) + " DICOM series; choose one",
                              Remedy::chooseSeries, ":" + listOf(series));
    return series.begin()->second;
}

Vec3 normalOf(const std::vector<double>& axes) {
    return Vec3(axes[0], axes[1], axes[2]).cross(Vec3(axes[3], axes[4], axes[5]));
}

void sortByNumber(std::vector<DicomHeader>& slices) {
    std::sort(slices.begin(), slices.end(), [](const DicomHeader& a, const DicomHeader& b) {
        return a.number != b.number ? a.number < b.number : naturallyBefore(a.file, b.file);
    });
}

void sortByPosition(std::vector<DicomHeader>& slices) {
    sortByNumber(slices);  // so that the messages below do not depend on the order of the files
    const DicomHeader& first = slices.front();
    for (DicomHeader& slice : slices) {
        if (slice.axes.empty())
            throw InvalidArgument("'" + slice.file + "' does not say where it is", Remedy::spaceSlicesByNumber);
        for (std::size_t n = 0; n < 6; ++n)
            if (!(std::abs(slice.axes[n] - first.axes[n]) < 1e-3))
                throw InvalidArgument("'" + slice.file + "' and '" + first.file +
                                      "' are turned against each other: these images are no volume");
    }
    const Vec3 normal = normalOf(first.axes);
    std::stable_sort(slices.begin(), slices.end(), [&](const DicomHeader& a, const DicomHeader& b) {
        return a.position.dot(normal) < b.position.dot(normal);
    });
}

/// From one slice to the next; not along the normal where the gantry was tilted.
/// Slices may be off by a tenth of it: scanners round positions, and a missing slice shows as half of it or more.
Vec3 stepOf(const std::vector<DicomHeader>& slices) {
    const auto last = slices.size() - 1;
    const Vec3 step = (slices[last].position - slices[0].position) / double(last);
    for (std::size_t n = 0; n <= last; ++n) {
        const double off = (slices[n].position - slices[0].position - step * double(n)).length();
        if (off < 0.1 * step.length()) continue;
        std::vector<double> gaps;
        for (std::size_t k = 0; k < last; ++k) gaps.push_back((slices[k + 1].position - slices[k].position).length());
        std::vector<double> sorted = gaps;
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(last / 2), sorted.end());
        const double usual = sorted[last / 2];
        const auto odd = std::max_element(
            gaps.begin(), gaps.end(), [&](double a, double b) { return std::abs(a - usual) < std::abs(b - usual); });
        const auto at = std::size_t(odd - gaps.begin());
        throw InvalidArgument("the slices are not equally spaced: " + number(*odd) + " mm from '" + slices[at].file +
                                  "' to '" + slices[at + 1].file + "', " + number(usual) +
                                  " mm elsewhere; is one missing, or are there two volumes?",
                              Remedy::spaceSlicesEvenly);
    }
    return step;
}

/// Where rescaling differs from slice to slice (PET), ITK gives their values different types.
bool codedAlike(const std::vector<DicomHeader>& slices) {
    return std::all_of(slices.begin(), slices.end(),
                       [&](const DicomHeader& slice) { return slice.coding == slices.front().coding; });
}

void convertToFloat(const StoredVolume& from, float* to) {
    withSampleType(from.type, [&](auto zero) {
        const auto* samples = reinterpret_cast<const decltype(zero)*>(from.samples.get());
        std::transform(samples, samples + from.count(), to, [](auto value) { return float(value); });
    });
}

StoredVolume readImage(const DicomHeader& slice, const Silence& silence) {
    StoredVolume image;
    const auto io = itk::GDCMImageIO::New();
    guarded(slice.file, "header", silence, [&] {
        io->SetFileName(slice.file);
        io->ReadImageInformation();
        image = describe(*io, slice.file);
    });
    image.samples.reset(new std::byte[image.count() * sizeOf(image.type)]);
    guarded(slice.file, "data", silence, [&] { readInto(*io, image.samples.get()); });
    return image;
}

/// Puts `image`, which is that of slice `n`, into its place in `volume`, which the first image makes.
void place(StoredVolume&& image, const std::vector<DicomHeader>& slices, std::size_t n, bool alike,
           StoredVolume& volume) {
    const DicomHeader& slice = slices[n];
    if (slices.size() == 1) {
        volume = std::move(image);
        return;
    }
    if (image.dims.z != 1)
        throw InvalidArgument("'" + slice.file + "' holds " + std::to_string(image.dims.z) +
                              " images of its own; give that file alone");
    if (n == 0) {
        volume.dims = Index3(image.dims.x, image.dims.y, int(slices.size()));
        volume.type = alike ? image.type : SampleType::float32;
        volume.origin = image.origin;
        volume.steps = image.steps;
        volume.samples.reset(new std::byte[volume.count() * sizeOf(volume.type)]);
    }
    if (image.dims.x != volume.dims.x || image.dims.y != volume.dims.y)
        throw InvalidArgument("the size of '" + slice.file + "' is " + std::to_string(image.dims.x) + "x" +
                              std::to_string(image.dims.y) + ", but that of the first image " +
                              std::to_string(volume.dims.x) + "x" + std::to_string(volume.dims.y));
    const std::size_t bytes = image.count() * sizeOf(volume.type);
    std::byte* to = volume.samples.get() + n * bytes;
    if (image.type == volume.type)
        std::memcpy(to, image.samples.get(), bytes);
    else if (volume.type == SampleType::float32)
        convertToFloat(image, reinterpret_cast<float*>(to));
    else
        throw InvalidArgument("the values of '" + slice.file + "' are " + nameOf(image.type) +
                              ", but those of the first image " + nameOf(volume.type));
}

}  // namespace

StoredVolume itkSeries(const std::vector<std::string>& files, const std::string& series, bool positions,
                       const ProgressCallback& progress) {
    StoredVolume volume;
    const Series all = seriesOf(files, progress, volume.complete);
    if (!volume.complete) return volume;
    if (all.empty()) failRead(files.front(), "there is no DICOM image in it");
    std::vector<DicomHeader> slices = choose(all, series);
    if (positions && slices.size() > 1)
        sortByPosition(slices);
    else
        sortByNumber(slices);

    const Silence silence;
    const bool alike = codedAlike(slices);
    const Vec3 step = positions && slices.size() > 1 ? stepOf(slices) : Vec3(0, 0, 1);
    for (std::size_t n = 0; n < slices.size(); ++n) {
        volume.complete = report(progress, "reading", double(n) / double(slices.size()));
        if (!volume.complete) return volume;
        place(readImage(slices[n], silence), slices, n, alike, volume);
    }
    if (positions && slices.size() > 1) volume.steps[2] = step;
    volume.format = "DICOM";
    volume.calibrated = true;
    return volume;
}

}  // namespace raysweep
