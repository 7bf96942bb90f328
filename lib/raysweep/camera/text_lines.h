/// Files of lines with words and numbers. For this module's own sources.
#pragma once

#include "raysweep/core/words.h"

#include <string>
#include <vector>

namespace raysweep {

struct TextLine {
    std::size_t number = 0;  ///< from 1
    std::string text;        ///< without what ends it
};

std::vector<TextLine> linesOf(const std::string& text);

/// Lines that hold something and are no comments, "# ...".
std::vector<TextLine> meantLinesOf(const std::string& text);

/// @throw IoError naming the word if it is not a finite number
double numberOf(const std::string& word);

/// @throw IoError naming the word if it is not a whole number from 0 to 2^53
long long countOf(const std::string& word);

}  // namespace raysweep
