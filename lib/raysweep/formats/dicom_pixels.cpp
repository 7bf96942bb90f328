// GDCM unpacks. What it makes of pixels on the way to a picture (inverting MONOCHROME1, one slope for all frames) is
// why its result is taken before that, and numbers are made of it here.
#include "raysweep/formats/dicom_pixels.h"

#include "raysweep/core/memory.h"
#include "raysweep/formats/itk_silence.h"
#include "raysweep/formats/read_failure.h"

#include <gdcmImageReader.h>

#include <cstring>
#include <vector>

namespace raysweep {
namespace {

/// The stored bits of each pixel, as numbers of the type Sample.
template <class Sample>
void takeBits(const std::vector<char>& bytes, const DicomPixels& pixels, std::size_t first, std::size_t stride,
              StoredVolume& volume) {
    const int width = 8 * int(sizeof(Sample));
    auto* const out = reinterpret_cast<Sample*>(volume.samples.get());
    using Bits = std::make_unsigned_t<Sample>;
    for (std::uint64_t n = 0; n < volume.count(); ++n) {
        Bits bits;
        std::memcpy(&bits, bytes.data() + (first + n * stride) * sizeof bits, sizeof bits);
        // To the top, and down again: what is above is gone, the sign is carried on.
        bits = Bits(bits << (width - 1 - pixels.highBit));
        out[n] = Sample(Sample(bits) >> (width - pixels.bitsStored));
    }
}

/// Channels side by side, or one plane after the other in every frame.
template <class Sample>
void takeChannel(const std::vector<char>& bytes, const DicomPixels& pixels, int channel, bool planes,
                 StoredVolume& volume) {
    if (!planes || pixels.channels == 1)
        return takeBits<Sample>(bytes, pixels, std::size_t(channel), std::size_t(pixels.channels), volume);
    const std::size_t plane = std::size_t(pixels.columns) * std::size_t(pixels.rows);
    StoredVolume frame;
    frame.dims = Index3(pixels.columns, pixels.rows, 1);
    for (std::size_t n = 0; n < std::size_t(pixels.frames); ++n) {
        frame.samples.reset(new std::byte[plane * sizeof(Sample)]);
        takeBits<Sample>(bytes, pixels, (n * std::size_t(pixels.channels) + std::size_t(channel)) * plane, 1, frame);
        std::memcpy(volume.samples.get() + n * plane * sizeof(Sample), frame.samples.get(), plane * sizeof(Sample));
    }
}

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

StoredVolume readDicomPixels(const std::string& file, const DicomPixels& pixels, int channel) {
    StoredVolume volume;
    volume.dims = Index3(pixels.columns, pixels.rows, pixels.frames);
    volume.type = storedType(pixels);
    const std::uint64_t bytes = volume.count() * std::uint64_t(pixels.bitsAllocated / 8);
    const std::uint64_t all = bytes * std::uint64_t(pixels.channels);
    requireBytes(double(all) + double(bytes), "'" + file + "': its pixels alone need", "convert it elsewhere first");

    const Silence silence;
    gdcm::ImageReader reader;
    reader.SetFileName(file.c_str());
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
        if constexpr (std::is_integral_v<Sample>) takeChannel<Sample>(buffer, pixels, channel, planes, volume);
    });
    return volume;
}

}  // namespace raysweep
