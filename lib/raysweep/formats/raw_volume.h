/// Volumes without a header: nothing but samples.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/stored_volume.h"

#include <cstdint>
#include <string>

namespace raysweep {

/// What a header would say.
struct RawLayout {
    Index3 dims{0};  ///< samples along x (fastest), y, z
    SampleType type = SampleType::uint8;
    bool bigEndian = false;
    std::uint64_t skip = 0;  ///< bytes before the first sample
};

/// Reads `path`, which must hold just `skip` bytes and the samples. Steps are 1, the origin is 0.
/// @throw InvalidArgument if a dimension is not positive, or the file has another size: it says which would fit.
/// @throw IoError if the file is missing or cannot be read.
StoredVolume readRawVolume(const std::string& path, const RawLayout& layout, const ProgressCallback& progress = {});

}  // namespace raysweep
