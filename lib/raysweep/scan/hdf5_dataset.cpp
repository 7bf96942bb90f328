// This and hdf5_sources.cpp are the only places that see HDF5.
#include "raysweep/scan/hdf5_dataset.h"

#include "raysweep/core/error.h"
#include "raysweep/core/regular_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/scan/hdf5_sources.h"

#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <type_traits>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

static_assert(std::is_same_v<hid_t, std::int64_t> && std::is_same_v<herr_t, int>);

[[noreturn]] void failRead(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

/// What the last call that failed says about the cause.
std::string reason() {
    std::string deepest;
    const auto keep = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
        if (error->desc) *static_cast<std::string*>(to) = error->desc;
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, keep, &deepest);
    return deepest.empty() ? "HDF5 gives no reason" : deepest;
}

/// IEEE's numbers of two bytes, which HDF5 has no name for.
hid_t halfFloat(bool bigEndian) {
    const hid_t type = H5Tcopy(bigEndian ? H5T_IEEE_F32BE : H5T_IEEE_F32LE);
    H5Tset_fields(type, 15, 10, 5, 0, 10);
    H5Tset_size(type, 2);
    H5Tset_ebias(type, 15);
    return type;
}

/// The number type that `type` is, bit by bit; nothing if it is another: HDF5 knows integers of any number of bits at
/// any place, and a damaged file can say what crashes its conversions.
std::optional<SampleType> sampleTypeOf(hid_t type) {
    const struct {
        hid_t little, big;
        SampleType type;
    } kKnown[] = {
        {H5T_STD_I8LE, H5T_STD_I8BE, SampleType::int8},        {H5T_STD_U8LE, H5T_STD_U8BE, SampleType::uint8},
        {H5T_STD_I16LE, H5T_STD_I16BE, SampleType::int16},     {H5T_STD_U16LE, H5T_STD_U16BE, SampleType::uint16},
        {H5T_STD_I32LE, H5T_STD_I32BE, SampleType::int32},     {H5T_STD_U32LE, H5T_STD_U32BE, SampleType::uint32},
        {H5T_STD_I64LE, H5T_STD_I64BE, SampleType::int64},     {H5T_STD_U64LE, H5T_STD_U64BE, SampleType::uint64},
        {H5T_IEEE_F32LE, H5T_IEEE_F32BE, SampleType::float32}, {H5T_IEEE_F64LE, H5T_IEEE_F64BE, SampleType::float64}};
    for (const auto& known : kKnown)
        if (H5Tequal(type, known.little) > 0 || H5Tequal(type, known.big) > 0) return known.type;
    for (const bool bigEndian : {false, true}) {
        const Hdf5Handle half(halfFloat(bigEndian), H5Tclose);
        if (H5Tequal(type, half) > 0) return SampleType::float32;
    }
    return {};
}

}  // namespace

QuietHdf5::QuietHdf5() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietHdf5::~QuietHdf5() {
    H5Eset_auto2(H5E_DEFAULT, print_, data_);
}

namespace {

std::int64_t openFile(const std::string& path) {
    if (const std::string why = whyNotRegular(path, "an HDF5 file"); !why.empty()) failRead(path, why);
    noteInput(path);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0) failRead(path, "it is no HDF5 file, or damaged (" + reason() + ")");
    return file;
}

}  // namespace

Hdf5File::Hdf5File(const std::string& path) : path_(path), file_(openFile(path), H5Fclose) {}

bool Hdf5File::has(const std::string& name) const {
    for (std::size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1))
        if (H5Lexists(file_, name.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
    return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Hdf5File::names() const {
    std::vector<std::string> names;
    const auto keep = [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
        static_cast<std::vector<std::string>*>(to)->push_back(name);
        return 0;
    };
    H5Literate(file_, H5_INDEX_NAME, H5_ITER_INC, nullptr, keep, &names);
    return names;
}

Hdf5Dataset::Hdf5Dataset(const Hdf5File& file, const std::string& name)
    : path_(file.path()), name_(name), set_(H5Dopen2(file.id(), name.c_str(), H5P_DEFAULT), H5Dclose) {
    if (set_ < 0) fail("it cannot be opened (" + reason() + ")");
    const Hdf5Handle creation(H5Dget_create_plist(set_), H5Pclose);
    if (const std::string why = noteHdf5Sources(path_, creation); !why.empty()) fail(why);
    const Hdf5Handle type(H5Dget_type(set_), H5Tclose);
    const H5T_class_t kind = type < 0 ? H5T_NO_CLASS : H5Tget_class(type);
    if (kind != H5T_INTEGER && kind != H5T_FLOAT) fail("it must hold numbers");
    const std::optional<SampleType> known = sampleTypeOf(type);
    if (!known)
        fail("its numbers are of a type that is not known (" + std::to_string(H5Tget_size(type)) + " bytes, " +
             std::to_string(H5Tget_precision(type)) +
             " bits); integers of 1, 2, 4 or 8 bytes and IEEE's floating-point numbers are");
    type_ = *known;
    const Hdf5Handle space(H5Dget_space(set_), H5Sclose);
    const int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    if (rank < 1 || rank > 3) fail("it has " + std::to_string(rank) + " dimensions");
    std::vector<hsize_t> sizes(static_cast<std::size_t>(rank));
    H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
    sizes_.assign(sizes.begin(), sizes.end());
    for (const std::uint64_t size : sizes_)
        if (size < 1 || size > 0x7fffffff) fail("its size is " + sizeText());
    requireWritten(creation);
    requireSources(creation);
}

void Hdf5Dataset::requireWritten(std::int64_t creation) const {
    const H5D_layout_t layout = H5Pget_layout(creation);
    bool written = true;
    if (layout == H5D_CHUNKED) {
        std::vector<hsize_t> chunk(sizes_.size());
        H5Pget_chunk(creation, int(chunk.size()), chunk.data());
        hsize_t chunks = 1, stored = 0;
        for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
            const hsize_t edge = std::max<hsize_t>(chunk[axis], 1);
            chunks *= sizes_[axis] / edge + (sizes_[axis] % edge != 0);
        }
        const Hdf5Handle space(H5Dget_space(set_), H5Sclose);
        written = H5Dget_num_chunks(set_, space, &stored) < 0 || stored >= chunks;
    } else if (layout == H5D_CONTIGUOUS && H5Pget_external_count(creation) == 0) {
        written = H5Dget_storage_size(set_) > 0;
    }
    if (!written) fail("parts of it were never written; was the scan interrupted?");
}

/// Of values that are in other files: that these are there.
void Hdf5Dataset::requireSources(std::int64_t creation) const {
    for (const Hdf5External& outside : hdf5Externals(creation)) {
        std::error_code failed;
        const auto there = fs::file_size(outside.file, failed);
        if (failed || (outside.size != H5F_UNLIMITED && there < outside.offset + outside.size))
            fail("its values are in the file '" + outside.file + "', which is missing or too short");
    }
    const std::vector<Hdf5Part> parts = hdf5Parts(path_, creation, sizes_);
    std::uint64_t covered = 0, all = parts.empty() ? 0 : 1;
    for (const std::uint64_t size : sizes_) all *= size;
    for (const Hdf5Part& part : parts) {
        covered += part.numbers;
        const Hdf5Handle file(H5Fopen(part.file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
        const Hdf5Handle opened(file < 0 ? -1 : H5Dopen2(file, part.set.c_str(), H5P_DEFAULT), H5Dclose);
        if (opened < 0)
            fail("it is put together of others, and '" + part.set + "' in '" + part.file + "' cannot be opened (" +
                 reason() + "); give that file as well, beside this one");
    }
    if (covered < all) fail("it is put together of others, which leave parts of it empty; was the scan interrupted?");
}

std::string Hdf5Dataset::sizeText() const {
    std::string text;
    for (const std::uint64_t size : sizes_) text += (text.empty() ? "" : " x ") + std::to_string(size);
    return text;
}

std::string Hdf5Dataset::attribute(const std::string& name) const {
    if (H5Aexists(set_, name.c_str()) <= 0) return "";
    const Hdf5Handle attribute(H5Aopen(set_, name.c_str(), H5P_DEFAULT), H5Aclose);
    const Hdf5Handle type(attribute < 0 ? -1 : H5Aget_type(attribute), H5Tclose);
    if (type < 0 || H5Tget_class(type) != H5T_STRING) return "";
    const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
    if (H5Sget_simple_extent_npoints(space) != 1) return "";
    const Hdf5Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_cset(memory, H5Tget_cset(type));
    if (H5Tis_variable_str(type) > 0) {
        H5Tset_size(memory, H5T_VARIABLE);
        char* text = nullptr;
        if (H5Aread(attribute, memory, &text) < 0 || !text) return "";
        const std::string copy = text;
        H5free_memory(text);
        return copy;
    }
    constexpr std::size_t kMost = 1 << 10;
    std::string text(std::min(H5Tget_size(type), kMost) + 1, '\0');
    H5Tset_size(memory, text.size());
    if (H5Aread(attribute, memory, text.data()) < 0) return "";
    return text.c_str();
}

void Hdf5Dataset::readAs(const Hdf5Extent& start, const Hdf5Extent& count, std::int64_t type, void* to) const {
    const std::vector<hsize_t> from(start.begin(), start.end()), numbers(count.begin(), count.end());
    const Hdf5Handle stored(H5Dget_space(set_), H5Sclose);
    const Hdf5Handle memory(H5Screate_simple(int(numbers.size()), numbers.data(), nullptr), H5Sclose);
    if (H5Sselect_hyperslab(stored, H5S_SELECT_SET, from.data(), nullptr, numbers.data(), nullptr) < 0 ||
        H5Dread(set_, type, memory, stored, H5P_DEFAULT, to) < 0)
        fail("it is damaged, or packed in a way that this build of HDF5 cannot unpack (" + reason() + ")");
}

void Hdf5Dataset::read(const Hdf5Extent& start, const Hdf5Extent& count, float* to) const {
    readAs(start, count, H5T_NATIVE_FLOAT, to);
}

void Hdf5Dataset::read(const Hdf5Extent& start, const Hdf5Extent& count, double* to) const {
    readAs(start, count, H5T_NATIVE_DOUBLE, to);
}

void Hdf5Dataset::fail(const std::string& why) const {
    failRead(path_, "/" + name_ + ": " + why);
}

}  // namespace raysweep
