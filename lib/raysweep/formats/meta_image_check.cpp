// ITK's reader keeps keys in a buffer of fixed size and writes beyond its end where they are longer, as in files that
// are something else under this name; so a header is looked at before it does.
#include "raysweep/formats/meta_image_check.h"

#include "raysweep/core/error.h"

#include <algorithm>
#include <fstream>

namespace raysweep {
namespace {

constexpr std::size_t kLongestKey = 200, kLongestLine = 30000, kLongestHeader = 1 << 20;

/// A byte that no header has.
bool isBinary(char c) {
    return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\r';
}

/// The next line, without its end; shorter than it is where it is longer than any header has.
bool nextLine(std::istream& in, std::string& line) {
    line.clear();
    for (int c; line.size() <= kLongestLine && (c = in.get()) != std::istream::traits_type::eof();) {
        if (c == '\n') return true;
        line.push_back(char(c));
    }
    return !line.empty();
}

}  // namespace

void checkMetaImage(const std::string& path) {
    const auto fail = [&](const std::string& why) {
        throw IoError("cannot read '" + path + "': in its header: " + why + "; it is no MetaImage, or damaged");
    };
    std::ifstream in(path, std::ios::binary);
    std::string line;
    std::size_t number = 0;
    for (std::size_t bytes = 0; bytes < kLongestHeader && nextLine(in, line); bytes += line.size() + 1) {
        const std::string where = "line " + std::to_string(++number);
        if (line.size() > kLongestLine || std::any_of(line.begin(), line.end(), isBinary)) fail(where + " is no text");
        if (std::all_of(line.begin(), line.end(), [](char c) { return c == ' ' || c == '\t' || c == '\r'; })) continue;
        const std::size_t separator = line.find_first_of("=:");
        if (separator == std::string::npos || separator > kLongestKey)
            fail(where + " is not of the form 'Key = value'");
        if (line.substr(0, line.find_first_of(" \t=:")) == "ElementDataFile") return;
    }
    fail(number == 0 ? "there is none" : "ElementDataFile is missing");
}

}  // namespace raysweep
