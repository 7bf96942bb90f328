/// The library CLI11, with one way to read numbers, whatever option takes them: decimal, a point and no comma whatever
/// the locale says, finite, up to 1e30, nothing before or behind but spaces. The library's own conversions differ by
/// type, and take 0x1p3, and 010 for 8; they are specialized here, where its types are known and nothing has used them
/// yet. Include this and not CLI/CLI.hpp.
#pragma once

#include <CLI/TypeTools.hpp>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>

namespace raysweep::apps {

/// Of what options take: squares and products of some must be numbers, too. Directions, whose length does not matter,
/// are read by parseDirection.
constexpr double kLargestNumber = 1e30;

/// @return false unless `text` is one finite number that `Number` can hold, and nothing else
template <class Number>
bool readNumber(const std::string& text, Number& value) {
    const char* begin = text.data();
    const char* end = begin + text.size();
    while (begin != end && *begin == ' ') ++begin;
    while (end != begin && end[-1] == ' ') --end;
    if (end - begin > 1 && begin[0] == '+' && begin[1] != '-') ++begin;
    const auto [stop, error] = std::from_chars(begin, end, value);
    return error == std::errc() && stop == end && std::isfinite(double(value));
}

}  // namespace raysweep::apps

namespace CLI::detail {

template <>
inline bool lexical_cast(const std::string& text, double& value) {
    return raysweep::apps::readNumber(text, value) && std::abs(value) <= raysweep::apps::kLargestNumber;
}
template <>
inline bool lexical_cast(const std::string& text, float& value) {
    return raysweep::apps::readNumber(text, value) && std::abs(value) <= raysweep::apps::kLargestNumber;
}
template <>
inline bool lexical_cast(const std::string& text, int& value) {
    return raysweep::apps::readNumber(text, value);
}
template <>
inline bool lexical_cast(const std::string& text, unsigned& value) {
    return raysweep::apps::readNumber(text, value);
}
template <>
inline bool lexical_cast(const std::string& text, std::int64_t& value) {
    return raysweep::apps::readNumber(text, value);
}
template <>
inline bool lexical_cast(const std::string& text, std::uint64_t& value) {
    return raysweep::apps::readNumber(text, value);
}

}  // namespace CLI::detail

#include <CLI/CLI.hpp>
