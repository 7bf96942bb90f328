#include "raysweep/formats/rescale.h"

#include "raysweep/core/memory.h"

#include <cmath>
#include <initializer_list>
#include <utility>

namespace raysweep {

SampleType rescaledType(SampleType type, const Rescaling& rescaling) {
    if (rescaling.isNone()) return type;
    const SampleType real = sizeOf(type) < 4 || type == SampleType::float32 ? SampleType::float32 : SampleType::float64;
    if (isFloatingPoint(type) || std::trunc(rescaling.slope) != rescaling.slope ||
        std::trunc(rescaling.intercept) != rescaling.intercept)
        return real;
    const double a = lowestOf(type) * rescaling.slope + rescaling.intercept;
    const double b = highestOf(type) * rescaling.slope + rescaling.intercept;
    for (const SampleType whole : {SampleType::int16, SampleType::uint16, SampleType::int32})
        if (std::min(a, b) >= lowestOf(whole) && std::max(a, b) <= highestOf(whole)) return whole;
    return real;
}

void rescaleInto(const std::byte* samples, SampleType from, std::uint64_t count, const Rescaling& rescaling,
                 SampleType to, std::byte* numbers) {
    withSampleType(from, [&](auto zero) {
        const auto* const in = reinterpret_cast<const decltype(zero)*>(samples);
        withSampleType(to, [&](auto target) {
            using Number = decltype(target);
            auto* const out = reinterpret_cast<Number*>(numbers);
            for (std::uint64_t n = 0; n < count; ++n)
                out[n] = Number(double(in[n]) * rescaling.slope + rescaling.intercept);
        });
    });
}

void rescale(StoredVolume& volume, const Rescaling& rescaling) {
    if (rescaling.isNone()) return;
    const SampleType type = rescaledType(volume.type, rescaling);
    const std::uint64_t bytes = volume.count() * sizeOf(type);
    requireBytes(double(bytes) + double(volume.count() * sizeOf(volume.type)), "the rescaled samples need",
                 "crop or resample the file elsewhere first");
    std::unique_ptr<std::byte[]> numbers(new std::byte[bytes]);
    rescaleInto(volume.samples.get(), volume.type, volume.count(), rescaling, type, numbers.get());
    volume.samples = std::move(numbers);
    volume.type = type;
    volume.highest = 0;
    volume.calibrated = true;
}

}  // namespace raysweep
