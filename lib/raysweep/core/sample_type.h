/// The number types that volumes and pictures are stored as in files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace raysweep {

enum class SampleType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// Bytes of one sample.
std::size_t sizeOf(SampleType type);

/// As users write it: "uint8", "float32" ...
std::string nameOf(SampleType type);

/// The type of that name; "float" and "double" are known too. Nothing if there is none.
std::optional<SampleType> sampleTypeOf(const std::string& name);

/// All names, separated by commas, for messages.
std::string sampleTypeNames();

bool isFloatingPoint(SampleType type);
bool isUnsigned(SampleType type);  ///< unsigned integer

/// Smallest and largest value of an integer type; 0 and 1 for floating-point types.
double lowestOf(SampleType type);
double highestOf(SampleType type);

/// Calls `use` with a zero of the C++ type that `type` stands for, and returns what it returns.
template <class Use>
auto withSampleType(SampleType type, const Use& use) {
    switch (type) {
        case SampleType::int8:
            return use(std::int8_t{});
        case SampleType::uint8:
            return use(std::uint8_t{});
        case SampleType::int16:
            return use(std::int16_t{});
        case SampleType::uint16:
            return use(std::uint16_t{});
        case SampleType::int32:
            return use(std::int32_t{});
        case SampleType::uint32:
            return use(std::uint32_t{});
        case SampleType::int64:
            return use(std::int64_t{});
        case SampleType::uint64:
            return use(std::uint64_t{});
        case SampleType::float32:
            return use(float{});
        case SampleType::float64:
            break;
    }
    return use(double{});
}

}  // namespace raysweep
