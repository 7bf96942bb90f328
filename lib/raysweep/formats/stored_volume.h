/// A dense volume as a file holds it.
#pragma once

#include "raysweep/core/sample_type.h"
#include "raysweep/core/types.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace raysweep {

/// Samples of one type on a lattice, i fastest, host byte order.
struct StoredVolume {
    Index3 dims{0};
    SampleType type = SampleType::uint8;
    std::unique_ptr<std::byte[]> samples;
    Vec3 origin{0};                                                          ///< world position of sample (0,0,0)
    std::array<Vec3, 3> steps{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};  ///< world, from a sample to the next
    std::string format;                                                      ///< "NRRD", "DICOM" ..., for reports
    std::string unit;                ///< of origin and steps: "mm", "um" ...; empty: the file does not say
    std::vector<std::string> notes;  ///< what whoever uses the numbers should know; each begins in lower case
    double highest = 0;       ///< that samples can be, where they have fewer bits than their type; 0: what that can be
    bool calibrated = false;  ///< the samples are what was measured (Hounsfield units, say), not shades of grey
    bool complete = true;     ///< false if the reader was asked to stop: then samples are missing

    /// Of the sample (i,j,k).
    std::size_t index(int i, int j, int k) const {
        return (std::size_t(k) * std::size_t(dims.y) + std::size_t(j)) * std::size_t(dims.x) + std::size_t(i);
    }
    std::uint64_t count() const { return std::uint64_t(dims.x) * std::uint64_t(dims.y) * std::uint64_t(dims.z); }
};

/// Voxels low to high, both included.
struct IndexBox {
    Index3 low{0}, high{0};
};

/// What the samples of a region range over.
struct SampleRange {
    double min = 0, max = 0;      ///< of the finite ones; both 0 if there is none
    std::uint64_t notFinite = 0;  ///< NaN and infinities
    Index3 firstNotFinite{0};     ///< the first in the order of the file
};

/// The range of all samples in `region`, which must lie within the volume.
SampleRange sampleRange(const StoredVolume& volume, const IndexBox& region);

}  // namespace raysweep
