/// Files of volumes, written byte by byte as their standards say, so that what reads them is checked by something else.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "raysweep/core/types.h"

namespace raysweep::test {

/// A header, if any, and bytes after it.
void writeFile(const std::string& path, const std::string& header, const std::string& bytes = "");

/// Samples as they are in memory (little endian), or with the bytes of each in reverse.
template <class Sample>
std::string bytesOf(const std::vector<Sample>& samples, bool bigEndian = false) {
    std::string bytes(samples.size() * sizeof(Sample), '\0');
    std::memcpy(bytes.data(), samples.data(), bytes.size());
    for (std::size_t n = 0; bigEndian && n < bytes.size(); n += sizeof(Sample))
        for (std::size_t b = 0; b < sizeof(Sample) / 2; ++b) std::swap(bytes[n + b], bytes[n + sizeof(Sample) - 1 - b]);
    return bytes;
}

/// Writes a number over what stands at `place`, little endian: to change a field of a header.
template <class Number>
void poke(std::string& bytes, std::size_t place, Number number) {
    std::memcpy(bytes.data() + place, &number, sizeof number);
}

/// NIfTI-1, int16, one file. `rows`: the sform, x' y' z' (RAS) from (i, j, k, 1).
struct NiftiImage {
    std::vector<int> dims;  ///< three, or four
    std::vector<std::int16_t> samples;
    float rows[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    float slope = 0, intercept = 0;  ///< slope 0: samples are not rescaled
};
std::string niftiBytes(const NiftiImage& image);

/// A DICOM data element with an explicit value representation of the short form.
std::string dicomElement(std::uint16_t group, std::uint16_t number, const std::string& vr, std::string value);

/// An image of a CT series: 16 bit, explicit VR, little endian.
struct DicomImage {
    int columns = 0, rows = 0;
    std::vector<std::uint16_t> samples;  ///< signed ones by their bits
    bool isSigned = true;
    int channels = 1;  ///< 3: colour
    int number = 1;
    std::string series = "1.2.3.4", description = "head";
    std::string position = "0\\0\\0", orientation = "1\\0\\0\\0\\1\\0";  ///< empty: not said
    std::string spacing = "1\\1";                                        ///< between rows, between columns, mm
    std::string slope = "1", intercept = "0";
    std::string photometric = "MONOCHROME2", type = "ORIGINAL\\PRIMARY";
    int bitsStored = 16, highBit = 15, frames = 1;
    std::string acquisition;             ///< elements of group 18
    std::string relation;                ///< elements of group 20, from (20,100) on
    std::string pixels;                  ///< elements of group 28, from (28,104) to (28,1050)
    std::vector<std::string> fragments;  ///< of pixels that are packed by run lengths (RLE), instead of samples
};
std::string dicomBytes(const DicomImage& image);
/// A fragment with one frame of 16 bits, of at most 128 pixels: a segment of the high bytes, and one of the low ones.
std::string dicomRunLengths(const std::vector<std::uint16_t>& samples);

/// A TIFF field: its values as bytes, or the one value of a LONG.
struct TiffField {
    std::uint16_t tag, type;
    std::uint32_t count;
    std::string bytes;
    TiffField(std::uint16_t tag, std::uint32_t value);
    TiffField(std::uint16_t tag, std::uint16_t type, std::uint32_t count, const std::string& bytes)
        : tag(tag), type(type), count(count), bytes(bytes) {}
};
/// One directory, by its fields but those of where the data are, and data of one strip.
struct TiffPage {
    std::vector<TiffField> fields;
    std::string data;
};
/// Little endian.
std::string tiffBytes(const std::vector<TiffPage>& pages);
/// Fields of a page of one sample per pixel, in one strip, without compression.
std::vector<TiffField> tiffFields(int width, int height, int bits, int photometric = 1, int format = 1);
/// What a page says about itself.
TiffField tiffDescription(const std::string& text);

/// Grey TIFF, not compressed, of one page or more.
std::string tiffBytes(int width, int height, const std::vector<std::vector<std::uint16_t>>& pages);

}  // namespace raysweep::test
