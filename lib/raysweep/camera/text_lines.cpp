#include "raysweep/camera/text_lines.h"

#include "raysweep/core/error.h"

#include <charconv>
#include <cmath>
#include <sstream>

namespace raysweep {

std::vector<TextLine> linesOf(const std::string& text) {
    std::vector<TextLine> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        lines.push_back({lines.size() + 1, line});
    }
    return lines;
}

std::vector<TextLine> meantLinesOf(const std::string& text) {
    std::vector<TextLine> meant;
    for (const TextLine& line : linesOf(text)) {
        const std::size_t start = line.text.find_first_not_of(kBlanks);
        if (start != std::string::npos && line.text[start] != '#') meant.push_back(line);
    }
    return meant;
}

double numberOf(const std::string& word) {
    const char *begin = word.data() + (word.size() > 1 && word[0] == '+' ? 1 : 0), *end = word.data() + word.size();
    double value = 0;
    const auto [stop, error] = std::from_chars(begin, end, value);  // whatever the locale
    if (error != std::errc() || stop != end || !std::isfinite(value)) throw IoError("'" + word + "' is not a number");
    return value;
}

long long countOf(const std::string& word) {
    const double value = numberOf(word);
    if (!(value >= 0 && value <= 9007199254740992.0 && value == std::floor(value)))
        throw IoError("'" + word + "' is not a whole number of 0 or more");
    return (long long)value;
}

}  // namespace raysweep
