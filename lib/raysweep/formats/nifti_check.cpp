// ITK fills what is missing at the end of a NIfTI file with zeros, does not come back from some transforms, and the
// library below it prints; none of that may happen, so a file is looked at before they see it.
#include "raysweep/formats/nifti_check.h"

#include "raysweep/core/error.h"

#include <nifti1_io.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <memory>

namespace raysweep {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

using Name = std::unique_ptr<char, decltype(&std::free)>;
using File = std::unique_ptr<gzFile_s, decltype(&gzclose)>;

/// Also reads files that are not compressed.
File open(const char* name) {
    return File(name ? gzopen(name, "rb") : nullptr, gzclose);
}

/// True if no number of the header's transforms is absurd.
bool hasPlace(const nifti_1_header& header) {
    const auto sane = [](const auto& numbers) {
        return std::all_of(std::begin(numbers), std::end(numbers), [](float n) { return std::abs(n) < 1e9f; });
    };
    return sane(header.pixdim) && sane(header.srow_x) && sane(header.srow_y) && sane(header.srow_z) &&
           sane(std::initializer_list<float>{header.quatern_b, header.quatern_c, header.quatern_d, header.qoffset_x,
                                             header.qoffset_y, header.qoffset_z});
}

bool readHeader(const std::string& path, nifti_1_header& header) {
    const Name name(nifti_findhdrname(path.c_str()), std::free);
    const File file = open(name.get());
    if (!file || gzread(file.get(), &header, sizeof header) != int(sizeof header)) return false;
    if (header.sizeof_hdr != int(sizeof header)) swap_nifti_header(&header, 1);
    return header.sizeof_hdr == int(sizeof header) && header.dim[0] >= 1 && header.dim[0] <= 7 &&
           nifti_hdr_looks_good(&header) && hasPlace(header);
}

}  // namespace

void checkNifti(const std::string& path) {
    nifti_set_debug_level(0);
    nifti_1_header header = {};
    if (!readHeader(path, header)) fail(path, "it is not a NIfTI-1 file, or its header is malformed");
    double end = header.vox_offset;
    double bytes = header.bitpix / 8;
    for (int n = 1; n <= header.dim[0]; ++n) bytes *= std::max(short(1), header.dim[n]);
    end += bytes;
    if (!(bytes >= 1 && end > 0 && end < 9e15)) fail(path, "its header promises no voxels, or more than there can be");

    const bool one = std::string(header.magic) == "n+1";
    const Name name(nifti_findimgname(path.c_str(), one ? NIFTI_FTYPE_NIFTI1_1 : NIFTI_FTYPE_NIFTI1_2), std::free);
    const File data = open(name.get());
    if (!data) fail(path, "there are no data beside its header");
    // In a compressed file this means to decompress it once more; it is the price of knowing.
    const bool whole = gzseek(data.get(), z_off_t(end) - 1, SEEK_SET) >= 0 && gzgetc(data.get()) >= 0;
    if (!whole)
        fail(path, "the data end too early: " + std::to_string(std::uint64_t(end)) +
                       " bytes are needed; the file is truncated, or its header is wrong");
}

}  // namespace raysweep
