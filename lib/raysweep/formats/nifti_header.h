/// What a NIfTI header says. Source: NIfTI-1 and NIfTI-2 data formats (nifti1.h, nifti2.h).
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace raysweep {

/// The fields that decide on numbers and places, of either version.
struct NiftiHeader {
    std::string dataFile;  ///< the file itself, or its .img
    bool detached = false;
    bool compressed = false;  ///< the data file, by gzip
    bool bigEndian = false;
    std::array<std::int64_t, 8> dim{};
    int datatype = 0, bitpix = 0;
    std::array<double, 8> pixdim{};
    std::uint64_t offset = 0;  ///< of the samples in the data file, unpacked
    double slope = 0, intercept = 0;
    int qformCode = 0, sformCode = 0, units = 0;
    std::array<double, 3> quaternion{}, qoffset{};
    std::array<std::array<double, 4>, 3> srow{};
};

/// @param path the file, its .hdr or its .img, each also compressed (.gz)
/// @throw IoError if it is no NIfTI, or numbers in it make no sense.
NiftiHeader readNiftiHeader(const std::string& path);

}  // namespace raysweep
