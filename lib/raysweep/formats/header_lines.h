/// Headers of text: lines, and numbers in them. Whatever the file is, what is read of it is bounded.
#pragma once

#include "raysweep/core/words.h"

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace raysweep {

/// @throw IoError if there is no such file, or it is a folder, a device or a pipe: those may never end.
void requireRegularFile(const std::string& path);
/// In bytes. @throw IoError as above
std::uint64_t sizeOfFile(const std::string& path);

/// The lines that a file begins with.
class HeaderLines {
  public:
    /// @throw IoError if it cannot be opened
    explicit HeaderLines(const std::string& path);

    /// The next line without its end (LF or CR LF). @return false at the end of the file @throw IoError for bytes that
    /// are no text, and for lines and headers longer than any real ones
    bool next(std::string& line);
    /// Where the byte after the last line is.
    std::uint64_t position() const { return position_; }
    /// @throw IoError "cannot read 'PATH': in its header, line N: WHY"
    [[noreturn]] void fail(const std::string& why) const;

  private:
    std::string path_;
    std::ifstream in_;
    std::uint64_t position_ = 0, number_ = 0;
};

std::string trimmed(const std::string& text);
std::string lowerCase(std::string text);
bool endsWith(const std::string& text, const std::string& end);
/// The number that `text` is, all of it; false if it is none, or none that fits. "nan" and "inf" are numbers.
bool toNumber(const std::string& text, double& number);
bool toWhole(const std::string& text, std::int64_t& number);
/// All words of `text`; false if one is no number.
bool toNumbers(const std::string& text, std::vector<double>& numbers);
bool toWholes(const std::string& text, std::vector<std::int64_t>& numbers);

}  // namespace raysweep
