/// Other files that the values of an HDF5 dataset are in: external storage, and the parts of virtual datasets.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raysweep {

/// A part of a virtual dataset: how many numbers come from which dataset of which file.
struct Hdf5Part {
    std::string file, set;
    std::uint64_t numbers = 0;
};

/// The parts of a virtual dataset; none if it is no such. Of a series ("part-%b.h5") those that its size asks for.
/// @param path of its file  @param creation its properties, an identifier of HDF5
std::vector<Hdf5Part> hdf5Parts(const std::string& path, std::int64_t creation,
                                const std::vector<std::uint64_t>& sizes);

/// A file that raw values are in, as seen from where the program runs.
struct Hdf5External {
    std::string file;
    std::uint64_t offset = 0, size = 0;  ///< bytes; a size of H5F_UNLIMITED is all behind the offset
};

/// @param creation as below
std::vector<Hdf5External> hdf5Externals(std::int64_t creation);

/// Remembers the files that a dataset's values are in, and those that theirs are in, as read (noteInput). To be called
/// before HDF5 is asked for the dataset's size, as it opens them then.
/// @return why one of them cannot be read, in words; empty if they can be, or are not there
std::string noteHdf5Sources(const std::string& path, std::int64_t creation);

}  // namespace raysweep
