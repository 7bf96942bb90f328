#include "raysweep/core/sample_type.h"

#include <limits>
#include <type_traits>
#include <utility>

namespace raysweep {
namespace {

constexpr std::pair<const char*, SampleType> kNames[] = {
    {"int8", SampleType::int8},       {"uint8", SampleType::uint8},   {"int16", SampleType::int16},
    {"uint16", SampleType::uint16},   {"int32", SampleType::int32},   {"uint32", SampleType::uint32},
    {"int64", SampleType::int64},     {"uint64", SampleType::uint64}, {"float32", SampleType::float32},
    {"float64", SampleType::float64}, {"float", SampleType::float32}, {"double", SampleType::float64}};

}  // namespace

std::size_t sizeOf(SampleType type) {
    return withSampleType(type, [](auto zero) { return sizeof zero; });
}

std::string nameOf(SampleType type) {
    for (const auto& [name, named] : kNames)
        if (named == type) return name;
    return "";
}

std::optional<SampleType> sampleTypeOf(const std::string& name) {
    for (const auto& [known, type] : kNames)
        if (name == known) return type;
    return std::nullopt;
}

std::string sampleTypeNames() {
    std::string all;
    for (const auto& entry : kNames) all += (all.empty() ? "" : ", ") + std::string(entry.first);
    return all;
}

bool isFloatingPoint(SampleType type) {
    return type == SampleType::float32 || type == SampleType::float64;
}

bool isUnsigned(SampleType type) {
    return withSampleType(type, [](auto zero) { return std::is_unsigned_v<decltype(zero)>; });
}

double lowestOf(SampleType type) {
    if (isFloatingPoint(type)) return 0;
    return withSampleType(type, [](auto zero) { return double(std::numeric_limits<decltype(zero)>::lowest()); });
}

double highestOf(SampleType type) {
    if (isFloatingPoint(type)) return 1;
    return withSampleType(type, [](auto zero) { return double(std::numeric_limits<decltype(zero)>::max()); });
}

}  // namespace raysweep
