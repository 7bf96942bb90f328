#include "raysweep/formats/nifti_header.h"

#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

namespace raysweep {
namespace {

constexpr std::size_t kSize1 = 348, kSize2 = 540;

/// The other of a pair, .hdr for .img and back; compressed or not, whichever there is.
std::string partnerOf(const std::string& path, const std::string& from, const std::string& to) {
    std::string stem = path;
    if (endsWith(lowerCase(stem), ".gz")) stem.resize(stem.size() - 3);
    stem.resize(stem.size() - from.size());
    std::string upper = to;
    for (char& c : upper) c = char(std::toupper(static_cast<unsigned char>(c)));
    for (const std::string& name : {stem + to, stem + to + ".gz", stem + upper, stem + upper + ".GZ"})
        if (std::filesystem::exists(name)) return name;
    failRead(path, "there is no '" + stem + to + "' beside it");
}

bool isPart(const std::string& path, const std::string& ending) {
    const std::string name = lowerCase(path);
    return endsWith(name, ending) || endsWith(name, ending + ".gz");
}

bool isGzip(const std::string& path) {
    char magic[2] = {};
    std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
    return magic[0] == '\x1f' && magic[1] == '\x8b';
}

/// The first bytes of a file, unpacked where it is compressed; fewer where there are no more.
std::string firstBytes(const std::string& path, std::size_t count) {
    requireRegularFile(path);
    const std::unique_ptr<gzFile_s, decltype(&gzclose)> file(gzopen(path.c_str(), "rb"), gzclose);
    std::string bytes(count, '\0');
    const int read = file ? gzread(file.get(), bytes.data(), unsigned(count)) : -1;
    if (read < 0) failRead(path, "it cannot be read, or its compressed data are damaged");
    bytes.resize(std::size_t(read));
    return bytes;
}

/// Numbers at their places in the header, in this machine's byte order.
class Fields {
  public:
    Fields(const std::string& bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}

    template <class Number>
    Number at(std::size_t place) const {
        std::byte raw[sizeof(Number)];
        std::memcpy(raw, bytes_.data() + place, sizeof raw);
        if (swapped_) std::reverse(raw, raw + sizeof raw);
        Number number;
        std::memcpy(&number, raw, sizeof raw);
        return number;
    }

    template <class Number, class Target, std::size_t count>
    void list(std::size_t place, std::array<Target, count>& to) const {
        for (std::size_t n = 0; n < count; ++n) to[n] = Target(at<Number>(place + n * sizeof(Number)));
    }

  private:
    const std::string& bytes_;
    bool swapped_;
};

void readVersion1(const Fields& fields, NiftiHeader& header, double& offset) {
    fields.list<std::int16_t>(40, header.dim);
    header.datatype = fields.at<std::int16_t>(70);
    header.bitpix = fields.at<std::int16_t>(72);
    fields.list<float>(76, header.pixdim);
    offset = fields.at<float>(108);
    header.slope = fields.at<float>(112);
    header.intercept = fields.at<float>(116);
    header.units = fields.at<std::uint8_t>(123);
    header.qformCode = fields.at<std::int16_t>(252);
    header.sformCode = fields.at<std::int16_t>(254);
    fields.list<float>(256, header.quaternion);
    fields.list<float>(268, header.qoffset);
    for (std::size_t row = 0; row < 3; ++row) fields.list<float>(280 + 16 * row, header.srow[row]);
}

void readVersion2(const Fields& fields, NiftiHeader& header, double& offset) {
    header.datatype = fields.at<std::int16_t>(12);
    header.bitpix = fields.at<std::int16_t>(14);
    fields.list<std::int64_t>(16, header.dim);
    fields.list<double>(104, header.pixdim);
    offset = double(fields.at<std::int64_t>(168));
    header.slope = fields.at<double>(176);
    header.intercept = fields.at<double>(184);
    header.qformCode = fields.at<std::int32_t>(344);
    header.sformCode = fields.at<std::int32_t>(348);
    fields.list<double>(352, header.quaternion);
    fields.list<double>(376, header.qoffset);
    for (std::size_t row = 0; row < 3; ++row) fields.list<double>(400 + 32 * row, header.srow[row]);
    header.units = fields.at<std::int32_t>(500);
}

/// 1 or 2; `detached` and `swapped` are set.
int versionOf(const std::string& path, const std::string& bytes, bool& detached, bool& swapped) {
    for (const bool other : {false, true}) {
        if (bytes.size() < kSize1) break;
        const auto size = Fields(bytes, other).at<std::int32_t>(0);
        const bool two = size == std::int32_t(kSize2);
        if (size != std::int32_t(kSize1) && !two) continue;
        if (two && bytes.size() < kSize2) break;
        swapped = other;
        const std::string magic = two ? bytes.substr(4, 4) : bytes.substr(344, 4);
        const std::string one(two ? "n+2\0" : "n+1\0", 4), pair(two ? "ni2\0" : "ni1\0", 4);
        detached = magic == pair;
        if (magic == one || detached) return two ? 2 : 1;
        if (!two)
            failRead(path, "it is Analyze 7.5, not NIfTI: it does not say which side is left; convert it",
                     Remedy::describeSamples);
    }
    failRead(path, "it is not a NIfTI file, or its header is malformed or ends early");
}

bool isSane(double number) {
    return std::abs(number) < 1e12;
}

void requireSane(const std::string& path, const NiftiHeader& header) {
    const auto fail = [&](const std::string& why) { failRead(path, "in its header: " + why); };
    if (header.dim[0] < 1 || header.dim[0] > 7) fail("dim[0] is " + std::to_string(header.dim[0]) + ", not 1 to 7");
    for (std::size_t n = 1; n <= std::size_t(header.dim[0]); ++n)
        if (header.dim[n] < 1) fail("dim[" + std::to_string(n) + "] is " + std::to_string(header.dim[n]));
    for (const auto& row : header.srow)
        if (header.sformCode > 0 && !std::all_of(row.begin(), row.end(), isSane)) fail("its sform is not finite");
    if (header.qformCode > 0 && !(std::all_of(header.quaternion.begin(), header.quaternion.end(), isSane) &&
                                  std::all_of(header.qoffset.begin(), header.qoffset.end(), isSane)))
        fail("its qform is not finite");
}

}  // namespace

NiftiHeader readNiftiHeader(const std::string& path) {
    requireRegularFile(path);
    const std::string headerFile = isPart(path, ".img") ? partnerOf(path, ".img", ".hdr") : path;
    const std::string bytes = firstBytes(headerFile, kSize2);
    NiftiHeader header;
    bool swapped = false;
    const int version = versionOf(headerFile, bytes, header.detached, swapped);
    header.bigEndian = swapped;  // this machine is little endian, as everywhere here
    double offset = 0;
    if (version == 1)
        readVersion1(Fields(bytes, swapped), header, offset);
    else
        readVersion2(Fields(bytes, swapped), header, offset);
    requireSane(headerFile, header);

    header.dataFile = path;
    if (header.detached && isPart(path, ".hdr")) header.dataFile = partnerOf(path, ".hdr", ".img");
    if (header.detached && header.dataFile == headerFile)
        failRead(path, "its data are in another file (.img), and only .hdr tells which");
    header.compressed = isGzip(header.dataFile);
    const double least = header.detached ? 0 : version == 1 ? 352 : 544;
    constexpr double kMost = 1 << 30;  // extensions of a gigabyte
    if (offset == 0) offset = least;
    if (!(offset >= least && offset <= kMost)) failRead(path, "in its header: vox_offset makes no sense");
    header.offset = std::uint64_t(offset);
    return header;
}

}  // namespace raysweep
