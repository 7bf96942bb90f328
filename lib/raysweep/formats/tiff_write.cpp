// The TIFF header of dense_headers.h. Source: Adobe, TIFF 6.0; ImageJ, ij.io.TiffEncoder (the description).
#include "raysweep/core/exact.h"
#include "raysweep/formats/dense_headers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace raysweep {
namespace {

enum Type : std::uint16_t { kText = 2, kShort = 3, kLong = 4, kRational = 5 };

struct Field {
    std::uint16_t tag;
    Type type;
    std::uint32_t count;
    std::string bytes;
};

template <class Number>
std::string bytesOf(Number number) {
    std::string bytes(sizeof number, '\0');
    std::memcpy(bytes.data(), &number, sizeof number);
    return bytes;
}

Field shortField(std::uint16_t tag, std::uint16_t value) {
    return {tag, kShort, 1, bytesOf(value)};
}

Field longField(std::uint16_t tag, std::uint32_t value) {
    return {tag, kLong, 1, bytesOf(value)};
}

/// The nearest number that has 32 bits above and at most 31 below.
Field rationalField(std::uint16_t tag, double value) {
    constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
    int bits = 31;
    while (bits > 0 && std::ldexp(value, bits) > kMost) --bits;
    const double above = std::min(kMost, std::max(1.0, std::round(std::ldexp(value, bits))));
    return {tag, kRational, 1, bytesOf(std::uint32_t(above)) + bytesOf(std::uint32_t(1) << bits)};
}

/// What ImageJ understands, and `raysweep_place`: the place of the first pixel, and the steps from column to column,
/// row to row and slice to slice, world units.
std::string descriptionOf(const DenseLayout& layout, int slice) {
    const Vec3 origin = layout.origin + layout.steps[2] * double(slice);
    std::string place;
    for (const Vec3& v : {origin, layout.steps[0], layout.steps[1], layout.steps[2]})
        for (int axis = 0; axis < 3; ++axis) place += " " + exact(v[axis]);
    return "ImageJ=1.53t\nimages=1\nunit=units\nspacing=" + exact(layout.steps[2].length()) +
           "\nraysweep_place=" + place.substr(1) + "\n";
}

/// A header, its one directory, and what is too long for that.
std::string assembled(std::vector<Field> fields, std::size_t offsetsField) {
    constexpr std::size_t kHead = 8, kEntry = 12, kInEntry = 4;
    const std::size_t longAt = kHead + 2 + kEntry * fields.size() + 4;
    std::size_t end = longAt;
    for (const Field& field : fields)
        if (field.bytes.size() > kInEntry) end += (field.bytes.size() + 1) & ~std::size_t(1);
    fields[offsetsField].bytes = bytesOf(std::uint32_t(end));
    std::string bytes = "II" + bytesOf(std::uint16_t(42)) + bytesOf(std::uint32_t(kHead));
    bytes += bytesOf(std::uint16_t(fields.size()));
    std::string longer;
    for (const Field& field : fields) {
        bytes += bytesOf(field.tag) + bytesOf(std::uint16_t(field.type)) + bytesOf(field.count);
        if (field.bytes.size() <= kInEntry) {
            bytes += field.bytes + std::string(kInEntry - field.bytes.size(), '\0');
            continue;
        }
        bytes += bytesOf(std::uint32_t(longAt + longer.size()));
        longer += field.bytes + std::string(field.bytes.size() % 2, '\0');
    }
    return bytes + std::string(4, '\0') + longer;
}

}  // namespace

std::string tiffHeader(const DenseLayout& layout, int slice) {
    constexpr double kMost = 4.29e9;  // offsets have 32 bits, and there is the header
    const double bytes = double(layout.dims.x) * double(layout.dims.y) * sizeof(float);
    if (bytes > kMost)
        throw InvalidArgument("a slice of " + std::to_string(layout.dims.x) + "x" + std::to_string(layout.dims.y) +
                              " voxels is larger than the 4 GB of a TIFF; write MetaImage or NRRD");
    std::string description = descriptionOf(layout, slice);
    description += '\0';
    const Vec3 spacing = layout.spacing();
    const auto width = std::uint32_t(layout.dims.x), height = std::uint32_t(layout.dims.y);
    constexpr std::uint16_t kNoCompression = 1, kBlackIsZero = 1, kNoUnit = 1, kFloats = 3;
    const std::vector<Field> fields = {
        longField(256, width),
        longField(257, height),
        shortField(258, 8 * sizeof(float)),
        shortField(259, kNoCompression),
        shortField(262, kBlackIsZero),
        {270, kText, std::uint32_t(description.size()), description},
        longField(273, 0),  // where the samples are: known last
        shortField(277, 1),
        longField(278, height),
        longField(279, std::uint32_t(bytes)),
        rationalField(282, 1 / spacing.x),
        rationalField(283, 1 / spacing.y),
        shortField(296, kNoUnit),
        shortField(339, kFloats),
    };
    constexpr std::size_t kOffsets = 6;
    return assembled(fields, kOffsets);
}

}  // namespace raysweep
