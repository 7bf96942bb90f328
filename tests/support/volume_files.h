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

/// NIfTI-1, int16, one file. `rows`: the sform, x' y' z' (RAS) from (i, j, k, 1).
struct NiftiImage {
    std::vector<int> dims;  ///< three, or four
    std::vector<std::int16_t> samples;
    float rows[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    float slope = 0, intercept = 0;  ///< slope 0: samples are not rescaled
};
std::string niftiBytes(const NiftiImage& image);

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
};
std::string dicomBytes(const DicomImage& image);

/// Grey TIFF, not compressed, of one page or more.
std::string tiffBytes(int width, int height, const std::vector<std::vector<std::uint16_t>>& pages);

}  // namespace raysweep::test
