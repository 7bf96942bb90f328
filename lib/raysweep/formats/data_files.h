/// Files of samples that a header names.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raysweep {

/// `file` as a header at `header` means it: beside it, unless the name says more.
/// @throw IoError if that is the header itself, or no regular file
std::string fileBeside(const std::string& header, const std::string& file);

/// Numbers that stand in names: first, last (included), step.
struct FileNumbers {
    std::int64_t first = 1, last = 1, step = 1;
};

/// True if `pattern` has one conversion of a whole number as printf knows them (%d, %03d, %i, %u), and no other; %% is
/// a percent sign. Nothing else may be used, for that would be read from, or written to, wherever it likes.
bool isNumberPattern(const std::string& pattern);

/// The names that such a pattern stands for. @throw IoError if it is none, or there are no numbers or more than a
/// million
std::vector<std::string> namesOf(const std::string& header, const std::string& pattern, const FileNumbers& numbers);

}  // namespace raysweep
