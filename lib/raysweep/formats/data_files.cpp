#include "raysweep/formats/data_files.h"

#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <cctype>
#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

/// A pattern in parts: what stands before and after the number, and how that is written.
struct Pattern {
    std::string before, after;
    std::size_t width = 0;
    bool zeros = false;
    int conversions = 0;
};

/// @return false for a conversion that is not one of those allowed
bool parse(const std::string& text, Pattern& pattern) {
    constexpr std::size_t kWidest = 20;
    for (std::size_t n = 0; n < text.size(); ++n) {
        std::string& part = pattern.conversions > 0 ? pattern.after : pattern.before;
        if (text[n] != '%') {
            part += text[n];
            continue;
        }
        if (++n < text.size() && text[n] == '%') {
            part += '%';
            continue;
        }
        if (n < text.size() && text[n] == '0') pattern.zeros = true, ++n;
        for (; n < text.size() && std::isdigit(static_cast<unsigned char>(text[n])); ++n) {
            pattern.width = 10 * pattern.width + std::size_t(text[n] - '0');
            if (pattern.width > kWidest) return false;
        }
        if (n >= text.size() || (text[n] != 'd' && text[n] != 'i' && text[n] != 'u')) return false;
        ++pattern.conversions;
    }
    return true;
}

std::string filled(const Pattern& pattern, std::int64_t number) {
    std::string digits = std::to_string(number);
    if (digits.size() < pattern.width) {
        const std::size_t sign = pattern.zeros && number < 0 ? 1 : 0;
        digits.insert(sign, pattern.width - digits.size(), pattern.zeros ? '0' : ' ');
    }
    return pattern.before + digits + pattern.after;
}

}  // namespace

std::string fileBeside(const std::string& header, const std::string& file) {
    const std::string path = fs::path(file).is_absolute() ? file : (fs::path(header).parent_path() / file).string();
    std::error_code ignored;
    if (fs::equivalent(path, header, ignored)) failRead(header, "its header says that it is the file of its own data");
    try {
        requireRegularFile(path);
    } catch (const IoError& error) {
        failRead(header, std::string("its data: ") + error.what());
    }
    return path;
}

bool isNumberPattern(const std::string& pattern) {
    Pattern parsed;
    return parse(pattern, parsed) && parsed.conversions == 1;
}

std::vector<std::string> namesOf(const std::string& header, const std::string& text, const FileNumbers& numbers) {
    constexpr std::int64_t kFar = std::int64_t(1) << 40, kMost = 1000000;
    Pattern pattern;
    if (!parse(text, pattern) || pattern.conversions != 1)
        failRead(header, "its data files are '" + text + "', which must have one number such as %d or %03d in it");
    const auto far = [&](std::int64_t number) { return number < -kFar || number > kFar; };
    if (numbers.step == 0 || far(numbers.first) || far(numbers.last) || far(numbers.step))
        failRead(header, "the numbers of its data files make no sense");
    const std::int64_t steps = (numbers.last - numbers.first) / numbers.step;
    const bool backwards = numbers.first != numbers.last && (numbers.last < numbers.first) != (numbers.step < 0);
    if (backwards || steps >= kMost)
        failRead(header, "the numbers of its data files are none, or more than there can be");
    std::vector<std::string> names;
    for (std::int64_t n = 0; n <= steps; ++n) names.push_back(filled(pattern, numbers.first + n * numbers.step));
    return names;
}

}  // namespace raysweep
