#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace raysweep {

/// Parts of `text` between spaces, tabs and ends of lines.
inline std::vector<std::string> wordsOf(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

}  // namespace raysweep
