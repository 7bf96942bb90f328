/// Samples that stand for other numbers.
#pragma once

#include "raysweep/formats/stored_volume.h"

namespace raysweep {

/// number = sample * slope + intercept, which a file asks for.
struct Rescaling {
    double slope = 1, intercept = 0;

    bool isNone() const { return slope == 1 && intercept == 0; }
};

/// The type that holds all such numbers: integers stay integers where slope and intercept are; else floats, of 64 bits
/// where samples have 32 or more.
SampleType rescaledType(SampleType type, const Rescaling& rescaling);

/// Replaces the samples by the numbers, which are what was measured: a slope or intercept says so. @throw
/// InvalidArgument if there is not enough memory
void rescale(StoredVolume& volume, const Rescaling& rescaling);

/// `count` samples of `from` become numbers of `to`, the type that rescaledType gave or a floating-point one.
void rescaleInto(const std::byte* samples, SampleType from, std::uint64_t count, const Rescaling& rescaling,
                 SampleType to, std::byte* numbers);

}  // namespace raysweep
