#include "support/volume_files.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace raysweep::test {
namespace {

template <class Number>
std::string little(Number value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class Number>
void put(std::string& bytes, std::size_t at, Number value) {
    bytes.replace(at, sizeof value, little(value));
}

std::string element(std::uint16_t group, std::uint16_t number, const std::string& vr, const std::string& value) {
    return dicomElement(group, number, vr, value);
}

std::string element(std::uint16_t group, std::uint16_t number, int value) {
    return element(group, number, "US", little(std::uint16_t(value)));
}

std::string placeElements(const DicomImage& image) {
    std::string bytes = element(0x20, 0xd, "UI", "1.2.3") + element(0x20, 0xe, "UI", image.series) +
                        element(0x20, 0x13, "IS", std::to_string(image.number));
    if (!image.position.empty()) bytes += element(0x20, 0x32, "DS", image.position);
    if (!image.orientation.empty()) bytes += element(0x20, 0x37, "DS", image.orientation);
    return bytes + image.relation;
}

std::string item(std::uint16_t number, const std::string& value) {
    return little(std::uint16_t(0xfffe)) + little(number) + little(std::uint32_t(value.size())) + value;
}

std::string pixelData(const DicomImage& image) {
    const std::string pixels = bytesOf(image.samples), reserved(2, '\0');
    if (image.fragments.empty()) return "OW" + reserved + little(std::uint32_t(pixels.size())) + pixels;
    std::string bytes = "OB" + reserved + std::string(4, '\xff') + item(0xe000, "");  // no table of places
    for (const std::string& fragment : image.fragments) bytes += item(0xe000, fragment);
    return bytes + item(0xe0dd, "");
}

std::string pixelElements(const DicomImage& image) {
    const bool color = image.channels == 3;
    std::string bytes = element(0x28, 0x2, image.channels);
    bytes += element(0x28, 0x4, "CS", color ? "RGB" : image.photometric);
    if (color) bytes += element(0x28, 0x6, 0);
    if (image.frames > 1) bytes += element(0x28, 0x8, "IS", std::to_string(image.frames));
    bytes += element(0x28, 0x10, image.rows) + element(0x28, 0x11, image.columns);
    bytes += element(0x28, 0x30, "DS", image.spacing);
    bytes += element(0x28, 0x100, 16) + element(0x28, 0x101, image.bitsStored) + element(0x28, 0x102, image.highBit);
    bytes += element(0x28, 0x103, image.isSigned ? 1 : 0) + image.pixels;
    bytes += element(0x28, 0x1052, "DS", image.intercept) + element(0x28, 0x1053, "DS", image.slope);
    return bytes + little(std::uint16_t(0x7fe0)) + little(std::uint16_t(0x10)) + pixelData(image);
}

}  // namespace

void writeFile(const std::string& path, const std::string& header, const std::string& bytes) {
    std::ofstream out(path, std::ios::binary);
    out << header << bytes;
    if (!out.flush()) throw std::runtime_error("cannot write " + path);
}

std::string dicomElement(std::uint16_t group, std::uint16_t number, const std::string& vr, std::string value) {
    if (value.size() % 2) value += vr == "UI" ? '\0' : ' ';
    return little(group) + little(number) + vr + little(std::uint16_t(value.size())) + value;
}

std::string niftiBytes(const NiftiImage& image) {
    std::string header(352, '\0');
    put(header, 0, std::int32_t(348));
    put(header, 40, std::int16_t(image.dims.size()));
    for (std::size_t n = 0; n < 7; ++n)
        put(header, 42 + 2 * n, std::int16_t(n < image.dims.size() ? image.dims[n] : 1));
    put(header, 70, std::int16_t(4));  // DT_INT16
    put(header, 72, std::int16_t(16));
    put(header, 76, 1.0f);
    for (std::size_t n = 0; n < 3; ++n)  // voxel sizes, which must agree with the sform
        put(header, 80 + 4 * n, std::hypot(image.rows[0][n], image.rows[1][n], image.rows[2][n]));
    put(header, 108, 352.0f);  // where the samples are
    put(header, 112, image.slope);
    put(header, 116, image.intercept);
    header[123] = 2;                    // millimetres
    put(header, 254, std::int16_t(1));  // sform: scanner coordinates
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t n = 0; n < 4; ++n) put(header, 280 + 16 * row + 4 * n, image.rows[row][n]);
    header.replace(344, 4, std::string("n+1\0", 4));
    return header + bytesOf(image.samples);
}

std::string dicomBytes(const DicomImage& image) {
    const std::string ct = "1.2.840.10008.5.1.4.1.1.2";
    const std::string syntax = image.fragments.empty() ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2.5";
    const std::string instance = image.series + "." + std::to_string(image.number);
    const std::string meta = element(2, 2, "UI", ct) + element(2, 3, "UI", instance) + element(2, 0x10, "UI", syntax);
    return std::string(128, '\0') + "DICM" + element(2, 0, "UL", little(std::uint32_t(meta.size()))) + meta +
           element(8, 0x8, "CS", image.type) + element(8, 0x16, "UI", ct) + element(8, 0x18, "UI", instance) +
           element(8, 0x60, "CS", "CT") + element(8, 0x103e, "LO", image.description) + image.acquisition +
           placeElements(image) + pixelElements(image);
}

std::string dicomRunLengths(const std::vector<std::uint16_t>& samples) {
    std::string high, low;
    for (const std::uint16_t sample : samples) high += char(sample >> 8), low += char(sample);
    const std::string literal(1, char(samples.size() - 1)), even(samples.size() % 2 == 0 ? 1 : 0, '\0');
    const std::string segment = literal + high + even;
    std::string header(64, '\0');
    put(header, 0, std::uint32_t(2));
    put(header, 4, std::uint32_t(header.size()));
    put(header, 8, std::uint32_t(header.size() + segment.size()));
    return header + segment + literal + low + even;
}

TiffField::TiffField(std::uint16_t tag, std::uint32_t value) : tag(tag), type(4), count(1), bytes(little(value)) {}

std::vector<TiffField> tiffFields(int width, int height, int bits, int photometric, int format) {
    const auto whole = [](int value) { return std::uint32_t(value); };
    return {
        {256, whole(width)},  {257, whole(height)}, {258, whole(bits)}, {259, 1}, {262, whole(photometric)}, {277, 1},
        {278, whole(height)}, {339, whole(format)}};
}

TiffField tiffDescription(const std::string& text) {
    return TiffField(270, 2, std::uint32_t(text.size() + 1), text + std::string(1, '\0'));
}

std::string tiffBytes(const std::vector<TiffPage>& pages) {
    std::string bytes = "II*" + std::string(5, '\0');
    std::size_t link = 4;  // where the offset of the next directory goes
    for (TiffPage page : pages) {
        page.fields.emplace_back(273, std::uint32_t(bytes.size()));
        page.fields.emplace_back(279, std::uint32_t(page.data.size()));
        std::sort(page.fields.begin(), page.fields.end(), [](const auto& a, const auto& b) { return a.tag < b.tag; });
        bytes += page.data;
        std::string directory = little(std::uint16_t(page.fields.size()));
        for (const TiffField& field : page.fields) {
            directory += little(field.tag) + little(field.type) + little(field.count);
            directory += field.bytes.size() > 4 ? little(std::uint32_t(bytes.size())) : field.bytes;
            directory.resize(2 + 12 * ((directory.size() - 2 + 11) / 12), '\0');
            if (field.bytes.size() > 4) bytes += field.bytes;
        }
        put(bytes, link, std::uint32_t(bytes.size()));
        bytes += directory;
        link = bytes.size();
        bytes += std::string(4, '\0');
    }
    return bytes;
}

std::string tiffBytes(int width, int height, const std::vector<std::vector<std::uint16_t>>& pages) {
    std::vector<TiffPage> all;
    for (const auto& page : pages) all.push_back({tiffFields(width, height, 16), bytesOf(page)});
    return tiffBytes(all);
}

}  // namespace raysweep::test
