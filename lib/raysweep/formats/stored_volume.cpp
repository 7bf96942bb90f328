#include "raysweep/formats/stored_volume.h"

#include "raysweep/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raysweep {
namespace {

/// Range of some samples; `add` in the order of the file.
struct PartRange {
    double min = std::numeric_limits<double>::infinity(), max = -std::numeric_limits<double>::infinity();
    std::uint64_t notFinite = 0;
    Index3 first{0};

    void addBad(std::uint64_t count, const Index3& at) {
        if (notFinite == 0) first = at;
        notFinite += count;
    }
    PartRange& operator+=(const PartRange& other) {
        min = std::min(min, other.min);
        max = std::max(max, other.max);
        if (other.notFinite) addBad(other.notFinite, other.first);
        return *this;
    }
};

template <class Sample>
PartRange rangeOfSlice(const StoredVolume& volume, const IndexBox& region, int k) {
    const auto* samples = reinterpret_cast<const Sample*>(volume.samples.get());
    PartRange range;
    for (int j = region.low.y; j <= region.high.y; ++j) {
        const Sample* row = samples + volume.index(0, j, k);
        for (int i = region.low.x; i <= region.high.x; ++i) {
            const double value = double(row[i]);
            if (std::isfinite(value)) {
                range.min = std::min(range.min, value);
                range.max = std::max(range.max, value);
            } else {
                range.addBad(1, Index3(i, j, k));
            }
        }
    }
    return range;
}

}  // namespace

SampleRange sampleRange(const StoredVolume& volume, const IndexBox& region) {
    const auto slices = std::size_t(region.high.z - region.low.z + 1);
    const auto all = withSampleType(volume.type, [&](auto zero) {
        return orderedSum<PartRange>(
            slices, [&](std::size_t n) { return rangeOfSlice<decltype(zero)>(volume, region, region.low.z + int(n)); },
            1);
    });
    SampleRange range{all.min, all.max, all.notFinite, all.first};
    if (!(range.min <= range.max)) range.min = range.max = 0;
    return range;
}

}  // namespace raysweep
