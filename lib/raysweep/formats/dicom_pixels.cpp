// GDCM unpacks. What it makes of pixels on the way to a picture (inverting MONOCHROME1, one slope for all frames) is
// why its result is taken before that, and numbers are made of it here.
#include "raysweep/formats/dicom_pixels.h"

#include "raysweep/core/memory.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/itk_silence.h"
#include "raysweep/formats/read_failure.h"

#include <gdcmImageReader.h>

#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

namespace raysweep {
namespace {

/// Where samples come from: one behind the other, or with those of other channels between them.
struct Samples {
    std::size_t first, stride, count;
};

/// The stored bits of each pixel, as numbers of the type Sample.
template <class Sample>
void takeBits(const std::vector<char>& bytes, const DicomPixels& pixels, const Samples& from, Sample* to) {
    constexpr int kWidth = 8 * int(sizeof(Sample));
    using Bits = std::make_unsigned_t<Sample>;
    for (std::size_t n = 0; n < from.count; ++n) {
        Bits bits;
        std::memcpy(&bits, bytes.data() + (from.first + n * from.stride) * sizeof bits, sizeof bits);
        // To the top, and down again: what is above is gone, the sign is carried on.
        bits = Bits(bits << (kWidth - 1 - pixels.highBit));
        to[n] = Sample(Sample(bits) >> (kWidth - pixels.bitsStored));
    }
}

/// Channels side by side, or one plane after the other in every frame.
template <class Sample>
void takeChannel(const std::vector<char>& bytes, const DicomPixels& pixels, std::size_t channel, bool planes,
                 Sample* to) {
    const auto channels = std::size_t(pixels.channels), frames = std::size_t(pixels.frames);
    const std::size_t plane = std::size_t(pixels.columns) * std::size_t(pixels.rows);
    if (!planes || channels == 1) return takeBits(bytes, pixels, {channel, channels, plane * frames}, to);
    for (std::size_t n = 0; n < frames; ++n, to += plane)
        takeBits(bytes, pixels, {(n * channels + channel) * plane, 1, plane}, to);
}

/// What GDCM may read of a file: what follows on the data set would be elements to it, one by one.
class DataSet {
  public:
    explicit DataSet(const DicomHeader& header) {
        if (header.end == sizeOfFile(header.file)) return;
        std::string bytes(header.end, '\0');
        std::ifstream(header.file, std::ios::binary).read(bytes.data(), std::streamsize(bytes.size()));
        cut_.str(std::move(bytes));
        isCut_ = true;
    }

    void giveTo(gdcm::ImageReader& reader, const std::string& file) {
        if (isCut_)
            reader.SetStream(cut_);
        else
            reader.SetFileName(file.c_str());
    }

  private:
    std::istringstream cut_;
    bool isCut_ = false;
};

}  // namespace

SampleType storedType(const DicomPixels& pixels) {
    switch (pixels.bitsAllocated) {
        case 8:
            return pixels.isSigned ? SampleType::int8 : SampleType::uint8;
        case 16:
            return pixels.isSigned ? SampleType::int16 : SampleType::uint16;
        default:
            return pixels.isSigned ? SampleType::int32 : SampleType::uint32;
    }
}

StoredVolume readDicomPixels(const DicomHeader& header, int channel) {
    const DicomPixels& pixels = header.pixels;
    const std::string& file = header.file;
    StoredVolume volume;
    volume.dims = Index3(pixels.columns, pixels.rows, pixels.frames);
    volume.type = storedType(pixels);
    const std::uint64_t bytes = volume.count() * std::uint64_t(pixels.bitsAllocated / 8);
    const std::uint64_t all = bytes * std::uint64_t(pixels.channels);
    requireBytes(double(all) + double(bytes), "'" + file + "': its pixels alone need", "convert it elsewhere first");

    const Silence silence;
    DataSet data(header);
    gdcm::ImageReader reader;
    data.giveTo(reader, file);
    if (!reader.Read())
        failRead(file, "its pixels cannot be unpacked: they are damaged, or of a kind that is not known");
    const gdcm::Image& image = reader.GetImage();
    const unsigned* const dims = image.GetDimensions();
    const bool same = dims[0] == unsigned(pixels.columns) && dims[1] == unsigned(pixels.rows) &&
                      (image.GetNumberOfDimensions() < 3 ? 1u : dims[2]) == unsigned(pixels.frames) &&
                      image.GetPixelFormat().GetBitsAllocated() == pixels.bitsAllocated &&
                      image.GetPixelFormat().GetSamplesPerPixel() == pixels.channels && image.GetBufferLength() == all;
    if (!same) failRead(file, "its pixels are not those that its header promises");
    std::vector<char> buffer(all);
    if (!image.GetBuffer(buffer.data())) failRead(file, "its pixels cannot be unpacked: they are damaged");

    volume.samples.reset(new std::byte[bytes]);
    const bool planes = image.GetPlanarConfiguration() == 1;
    withSampleType(volume.type, [&](auto zero) {
        using Sample = decltype(zero);
        if constexpr (std::is_integral_v<Sample>)
            takeChannel(buffer, pixels, std::size_t(channel), planes, reinterpret_cast<Sample*>(volume.samples.get()));
    });
    return volume;
}

}  // namespace raysweep
