/// What the header of a volume says of its samples, and reading them.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/formats/sample_source.h"
#include "raysweep/formats/stored_volume.h"

#include <cstdint>
#include <string>
#include <vector>

namespace raysweep {

/// An axis of the array in the file: one of i, j, k in that order, or one along which a single index is read.
struct DeclaredAxis {
    std::int64_t size = 1;
    bool spatial = true;
    std::int64_t chosen = 0;  ///< where it is not spatial
};

struct DeclaredSamples {
    SampleType type = SampleType::uint8;
    bool bigEndian = false;
    SampleCoding coding = SampleCoding::raw;
    std::vector<DeclaredAxis> axes;  ///< fastest first; at most three are spatial
    std::vector<DataPiece> pieces;   ///< one behind the other, each with as many samples; see splitEvenly
    bool exact = false;              ///< data that go on behind the samples are an error, not a note
};

/// Bytes of the samples along all axes. @throw IoError if an axis has no samples, or there are more than can be
std::uint64_t bytesOf(const DeclaredSamples& samples, const std::string& path);

/// Shares the samples out among the pieces, all alike. @throw IoError where that does not come out even
void splitEvenly(DeclaredSamples& samples, const std::string& path);

/// Dimensions, type and samples; steps are 1, the origin is 0. A stop asked for by `progress` leaves it incomplete.
/// @throw IoError as requirePieces, and for damaged data. @throw InvalidArgument if there is not enough memory.
StoredVolume readDeclared(const std::string& path, const DeclaredSamples& samples,
                          const ProgressCallback& progress = {});

}  // namespace raysweep
