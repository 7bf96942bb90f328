#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace raysweep {

/// What is between words.
constexpr const char* kBlanks = " \t\n\v\f\r";

/// Parts of `text` between blanks.
inline std::vector<std::string> wordsOf(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

}  // namespace raysweep
