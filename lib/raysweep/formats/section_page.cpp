#include "raysweep/formats/section_page.h"
#include "raysweep/core/output_file.h"
#include "raysweep/formats/sections.h"

#include <zlib.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace raysweep {
namespace {

using Bytes = std::vector<unsigned char>;

constexpr int kSlab = 8;                                 ///< slices that are packed together
constexpr std::uint64_t kMost = std::uint64_t(1) << 30;  ///< voxels: what browsers have room for

std::string base64(const Bytes& bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t n = 0; n < bytes.size(); n += 3) {
        const std::size_t left = std::min<std::size_t>(3, bytes.size() - n);
        unsigned group = 0;
        for (std::size_t b = 0; b < 3; ++b) group = group << 8 | (b < left ? bytes[n + b] : 0u);
        for (std::size_t d = 0; d < 4; ++d) text += d <= left ? kDigits[group >> (18 - 6 * d) & 63] : '=';
    }
    return text;
}

Bytes packed(const Bytes& bytes) {
    uLongf size = compressBound(uLong(bytes.size()));
    Bytes result(size);
    if (compress2(result.data(), &size, bytes.data(), uLong(bytes.size()), Z_DEFAULT_COMPRESSION) != Z_OK)
        throw IoError("zlib cannot be used");
    result.resize(size);
    return result;
}

/// What 0 and 255 stand for.
GreyWindow codedRange(const SectionOptions& options, const Sections& sections) {
    return options.window.value_or(GreyWindow{sections.smallest, sections.largest});
}

nlohmann::ordered_json listOf(const Vec3& v) {
    return {v.x, v.y, v.z};
}
nlohmann::ordered_json listOf(const Index3& v) {
    return {v.x, v.y, v.z};
}

/// What the page's script has to know. "<" would end the element that it stands in.
std::string aboutOf(const std::string& name, const GreyWindow& coded, const Sections& sections) {
    const DenseLayout& layout = sections.layout;
    nlohmann::ordered_json json = {{"name", name},
                                   {"dims", listOf(layout.dims)},
                                   {"corner", listOf(sections.corner)},
                                   {"at", listOf(sections.at)},
                                   {"origin", listOf(layout.origin)},
                                   {"spacing", listOf(layout.spacing())},
                                   {"coded", {coded.low, coded.high}},
                                   {"range", {sections.smallest, sections.largest}},
                                   {"sheared", !hasRightAngles(layout)}};
    for (int axis = 0; axis < 3; ++axis) {
        json["steps"].push_back(listOf(layout.steps[std::size_t(axis)]));
        json["axes"].push_back(axisName(layout, axis));
    }
    std::string text = json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
    for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
    return text;
}

void writeSlabs(DenseSource& source, const GreyWindow& coded, std::ofstream& out) {
    const Index3& dims = source.layout().dims;
    const std::size_t size = std::size_t(dims.x) * std::size_t(dims.y);
    const double factor = coded.high > coded.low ? 255 / (coded.high - coded.low) : 0;
    for (int first = 0; first < dims.z; first += kSlab) {
        Bytes codes;
        for (int k = first; k < std::min(first + kSlab, dims.z); ++k) {
            const float* const slice = source.slice(k);
            for (std::size_t n = 0; n < size; ++n)
                codes.push_back(
                    (unsigned char)(std::lround(std::clamp((double(slice[n]) - coded.low) * factor, 0.0, 255.0))));
        }
        out << "<script type=\"text/plain\" class=\"slab\">" << base64(packed(codes)) << "</script>\n";
    }
}

}  // namespace

void writeSectionPage(const std::string& path, DenseSource& source, const SectionOptions& options,
                      const Sections& sections) {
    const DenseLayout& layout = source.layout();
    if (layout.samples() > kMost)
        throw InvalidArgument("the page would hold " + std::to_string(layout.dims.x) + "x" +
                              std::to_string(layout.dims.y) + "x" + std::to_string(layout.dims.z) +
                              " voxels, and browsers have room for 2^30; choose a smaller part by `denseBox`, or use "
                              "a coarser grid");
    const GreyWindow coded = codedRange(options, sections);
    OutputFile file(path);
    std::ofstream out(file.temporary(), std::ios::binary);
    out << kPageBeforeData << "<script type=\"application/json\" id=\"about\">"
        << aboutOf(source.name(), coded, sections) << "</script>\n";
    writeSlabs(source, coded, out);
    out << kPageAfterData;
    out.close();
    if (!out) throw IoError("cannot write '" + path + "': writing failed; is the disk full?");
    file.commit();
}

}  // namespace raysweep
