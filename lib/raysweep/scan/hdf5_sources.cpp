#include "raysweep/scan/hdf5_sources.h"

#include "raysweep/core/regular_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/scan/hdf5_dataset.h"

#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

/// One of the mappings of a virtual dataset.
struct Mapping {
    std::string file, set;  ///< as it is written, with %b for the number of a block
    Hdf5Handle where;       ///< selection of the virtual dataset

    Mapping(hid_t creation, std::size_t n) : where(H5Pget_virtual_vspace(creation, n), H5Sclose) {
        char name[4096] = {};
        H5Pget_virtual_filename(creation, n, name, sizeof name);
        file = name;
        H5Pget_virtual_dsetname(creation, n, name, sizeof name);
        set = name;
    }
    bool isSeries() const { return file.find("%b") != std::string::npos || set.find("%b") != std::string::npos; }
};

std::size_t mappingsOf(hid_t creation) {
    std::size_t count = 0;
    if (H5Pget_layout(creation) == H5D_VIRTUAL) H5Pget_virtual_count(creation, &count);
    return count;
}

/// What HDF5 makes of %b, and of %%.
std::string numbered(const std::string& name, std::uint64_t block) {
    std::string text;
    for (std::size_t i = 0; i < name.size(); ++i) {
        const char next = name[i] == '%' && i + 1 < name.size() ? name[i + 1] : '\0';
        if (next == 'b') text += std::to_string(block);
        if (next == '%') text += '%';
        if (next == 'b' || next == '%')
            ++i;
        else
            text += name[i];
    }
    return text;
}

/// "." is the file itself; names are as seen from where it is.
std::string sourcePath(const std::string& path, const std::string& name) {
    if (name == ".") return path;
    return fs::path(name).is_absolute() ? name : (fs::path(path).parent_path() / name).string();
}

/// What a selection covers of a dataset that may have grown: how many numbers, in how many blocks along the dimension
/// that grows.
struct Covered {
    std::uint64_t numbers = 0, blocks = 1;
};

Covered coveredBy(hid_t where, const std::vector<std::uint64_t>& sizes) {
    if (H5Sget_select_type(where) != H5S_SEL_HYPERSLABS || H5Sis_regular_hyperslab(where) <= 0)
        return {std::uint64_t(std::max<hssize_t>(0, H5Sget_select_npoints(where))), 1};
    std::vector<hsize_t> start(sizes.size()), stride(sizes.size()), count(sizes.size()), block(sizes.size());
    H5Sget_regular_hyperslab(where, start.data(), stride.data(), count.data(), block.data());
    Covered covered{1, 1};
    for (std::size_t axis = 0; axis < sizes.size(); ++axis) {
        const hsize_t left = sizes[axis] > start[axis] ? sizes[axis] - start[axis] : 0;
        const hsize_t step = std::max<hsize_t>(stride[axis], 1), whole = left / step, rest = left % step;
        hsize_t here = left;
        if (block[axis] != H5S_UNLIMITED)
            here = whole >= count[axis] ? count[axis] * block[axis] : whole * block[axis] + std::min(rest, block[axis]);
        covered.numbers *= here;
        if (count[axis] == H5S_UNLIMITED) covered.blocks = whole + (rest != 0);
    }
    return covered;
}

/// Goes through the files that values are in, and those that theirs are in, each dataset once.
class SourceWalk {
  public:
    std::string walk(const std::string& path, hid_t creation) {
        for (const Hdf5External& outside : hdf5Externals(creation))
            if (const std::string why = note(outside.file); !why.empty()) return why;
        for (std::size_t n = 0; n < mappingsOf(creation); ++n)
            if (const std::string why = walk(path, Mapping(creation, n)); !why.empty()) return why;
        return "";
    }

  private:
    std::string walk(const std::string& path, const Mapping& mapping) {
        for (std::uint64_t block = 0; block == 0 || mapping.isSeries(); ++block) {
            const std::string file = sourcePath(path, numbered(mapping.file, block));
            const std::string set = numbered(mapping.set, block);
            if (!seen_.insert({file, set}).second) break;
            if (std::error_code failed; !fs::exists(file, failed)) break;  // where HDF5 ends a series
            if (const std::string why = note(file); !why.empty()) return why;
            const Hdf5Handle opened(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
            const Hdf5Handle source(opened < 0 ? -1 : H5Dopen2(opened, set.c_str(), H5P_DEFAULT), H5Dclose);
            if (source < 0) break;
            const Hdf5Handle creation(H5Dget_create_plist(source), H5Pclose);
            if (const std::string why = walk(file, creation); !why.empty()) return why;
        }
        return "";
    }

    std::string note(const std::string& file) {
        if (std::error_code failed; !fs::exists(file, failed)) return "";
        if (const std::string why = whyNotRegular(file, "a file"); !why.empty())
            return "its values are in '" + file + "': " + why;
        noteInput(file);
        return "";
    }

    std::set<std::pair<std::string, std::string>> seen_;
};

}  // namespace

std::vector<Hdf5External> hdf5Externals(std::int64_t creation) {
    std::vector<Hdf5External> files;
    const int count = H5Pget_external_count(creation);
    for (int n = 0; n < count; ++n) {
        char name[4096] = {};
        off_t offset = 0;
        hsize_t size = 0;
        H5Pget_external(creation, unsigned(n), sizeof name - 1, name, &offset, &size);
        files.push_back({name, std::uint64_t(offset), size});
    }
    return files;
}

std::vector<Hdf5Part> hdf5Parts(const std::string& path, std::int64_t creation,
                                const std::vector<std::uint64_t>& sizes) {
    std::vector<Hdf5Part> parts;
    for (std::size_t n = 0; n < mappingsOf(creation); ++n) {
        const Mapping mapping(creation, n);
        const Covered covered = coveredBy(mapping.where, sizes);
        for (std::uint64_t block = 0; block < (mapping.isSeries() ? covered.blocks : 1); ++block)
            parts.push_back({sourcePath(path, numbered(mapping.file, block)), numbered(mapping.set, block),
                             block == 0 ? covered.numbers : 0});
    }
    return parts;
}

std::string noteHdf5Sources(const std::string& path, std::int64_t creation) {
    return SourceWalk().walk(path, creation);
}

}  // namespace raysweep
