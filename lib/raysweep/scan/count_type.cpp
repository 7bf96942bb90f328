#include "raysweep/scan/count_type.h"

#include "raysweep/core/brief.h"
#include "raysweep/core/error.h"

#include <cmath>

namespace raysweep {
namespace {

bool canWrap(SampleType type) {
    return !isFloatingPoint(type) && !isUnsigned(type);
}

}  // namespace

void addWrapped(float* values, std::size_t count, SampleType type) {
    if (!canWrap(type)) return;
    const float all = float(std::ldexp(1.0, int(8 * sizeOf(type))));
    for (std::size_t p = 0; p < count; ++p)
        if (values[p] < 0) values[p] += all;
}

void requireCounts(double least, SampleType type, const std::string& what) {
    // Cameras that subtract their own dark frames count a little below 0.
    constexpr double kNoise = 0.1;
    if (!canWrap(type) || !(least < kNoise * lowestOf(type))) return;
    throw InvalidArgument(what + ": counts are as low as " + brief(least, 6) + ", as those are that were stored as " +
                          nameOf(type) + " but are too large for it; store them as u" + nameOf(type) +
                          ", or say with `unsignedCounts` that they are meant so");
}

}  // namespace raysweep
