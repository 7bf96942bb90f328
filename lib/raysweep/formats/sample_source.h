/// The bytes of samples as they are once unpacked, from one file or several.
#pragma once

#include "raysweep/core/sample_type.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace raysweep {

enum class SampleCoding {
    raw,
    deflate,  ///< gzip or zlib
    text,     ///< numbers, separated by blanks or commas
    hex       ///< two digits a byte
};

/// A file, or the part of one, that holds samples.
struct DataPiece {
    std::string file;
    std::uint64_t skip = 0;          ///< bytes of the file before them
    std::uint64_t skipUnpacked = 0;  ///< bytes before them once unpacked
    std::uint64_t bytes = 0;         ///< of samples, unpacked
};

/// @throw IoError where a file is missing, is no regular one, or cannot hold what it has to: known before anything is
/// read or allocated, so that what a header promises is bounded by what there is.
void requirePieces(const std::vector<DataPiece>& pieces, SampleCoding coding, SampleType type);

/// One piece after the other.
class SampleSource {
  public:
    virtual ~SampleSource() = default;
    /// Whole samples. @throw IoError where the data are damaged, or end early
    virtual void read(std::byte* to, std::uint64_t bytes) = 0;
    virtual void skip(std::uint64_t bytes) = 0;
    /// To be called when a piece was read. @return bytes, or at least 1, that it has beyond its samples
    /// @throw IoError where the check sum is wrong
    virtual std::uint64_t rest() = 0;
};

std::unique_ptr<SampleSource> openPiece(const DataPiece& piece, SampleCoding coding, SampleType type);

}  // namespace raysweep
