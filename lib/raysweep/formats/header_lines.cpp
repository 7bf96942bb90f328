#include "raysweep/formats/header_lines.h"

#include "raysweep/core/regular_file.h"
#include "raysweep/formats/read_failure.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <sstream>

namespace raysweep {
namespace {

constexpr std::size_t kLongestLine = 1 << 20, kLongestHeader = 1 << 24;

/// A byte that no header has.
bool isBinary(char c) {
    return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\r' && c != '\f' && c != '\v';
}

template <class Number, class Convert>
bool toAll(const std::string& text, std::vector<Number>& numbers, const Convert& convert) {
    numbers.clear();
    for (const std::string& word : wordsOf(text)) {
        numbers.emplace_back();
        if (!convert(word, numbers.back())) return false;
    }
    return true;
}

}  // namespace

void requireRegularFile(const std::string& path) {
    if (const std::string why = whyNotRegular(path, "a file"); !why.empty()) failRead(path, why);
}

std::uint64_t sizeOfFile(const std::string& path) {
    requireRegularFile(path);
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    if (error) failRead(path, error.message());
    return size;
}

HeaderLines::HeaderLines(const std::string& path) : path_(path) {
    requireRegularFile(path);
    in_.open(path, std::ios::binary);
    if (!in_) failRead(path, "it cannot be opened");
}

bool HeaderLines::next(std::string& line) {
    line.clear();
    ++number_;
    int c = 0;
    while ((c = in_.get()) != std::ifstream::traits_type::eof() && c != '\n') {
        if (isBinary(char(c))) fail("this is no text");
        if (line.size() >= kLongestLine) fail("it is longer than any line of a header");
        line.push_back(char(c));
    }
    position_ += line.size() + (c == '\n' ? 1 : 0);
    if (position_ > kLongestHeader) fail("the header is longer than any");
    const bool found = c == '\n' || !line.empty();
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return found;
}

void HeaderLines::fail(const std::string& why) const {
    failRead(path_, "in its header, line " + std::to_string(number_) + ": " + why);
}

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(kBlanks);
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string lowerCase(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool toNumber(const std::string& text, double& number) {
    char* end = nullptr;
    number = std::strtod(text.c_str(), &end);
    return !text.empty() && end == text.c_str() + text.size();
}

bool toWhole(const std::string& text, std::int64_t& number) {
    char* end = nullptr;
    errno = 0;
    number = std::strtoll(text.c_str(), &end, 10);
    return !text.empty() && end == text.c_str() + text.size() && errno == 0;
}

bool toNumbers(const std::string& text, std::vector<double>& numbers) {
    return toAll(text, numbers, toNumber);
}

bool toWholes(const std::string& text, std::vector<std::int64_t>& numbers) {
    return toAll(text, numbers, toWhole);
}

}  // namespace raysweep
