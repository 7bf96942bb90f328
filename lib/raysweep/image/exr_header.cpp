// "OpenEXR File Layout": magic number and version, then for each part attributes up to an empty name, each a name, a
// type, a length and a value, then for each part a table with the places of its chunks, eight bytes each.
#include "raysweep/image/exr_header.h"

#include "raysweep/image/picture_file.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>

namespace raysweep {
namespace {

constexpr std::int32_t kSeveralParts = 0x1000;  ///< flag beside the version

/// Types of which OpenEXR reads these many bytes, whatever their length is said to be: what follows would be taken for
/// something else there than here.
const std::map<std::string, std::int64_t> kFixedLengths = {{"box2i", 16},
                                                           {"box2f", 16},
                                                           {"chromaticities", 32},
                                                           {"compression", 1},
                                                           {"deepImageState", 1},
                                                           {"double", 8},
                                                           {"envmap", 1},
                                                           {"float", 4},
                                                           {"int", 4},
                                                           {"keycode", 28},
                                                           {"lineOrder", 1},
                                                           {"m33f", 36},
                                                           {"m33d", 72},
                                                           {"m44f", 64},
                                                           {"m44d", 128},
                                                           {"rational", 8},
                                                           {"tiledesc", 9},
                                                           {"timecode", 8},
                                                           {"v2i", 8},
                                                           {"v2f", 8},
                                                           {"v2d", 16},
                                                           {"v3i", 12},
                                                           {"v3f", 12},
                                                           {"v3d", 24}};

class Reader {
  public:
    explicit Reader(const std::string& path) : path_(path), file_(path, std::ios::binary | std::ios::ate) {
        length_ = file_.tellg();
        file_.seekg(0);
    }

    [[noreturn]] void fail(const std::string& what) const { failToRead(path_, what + "; it is damaged"); }

    std::string text() {
        std::string text;
        std::getline(file_, text, '\0');
        requireMore(0);
        return text;
    }

    std::int32_t integer() {
        unsigned char b[4] = {};
        file_.read(reinterpret_cast<char*>(b), sizeof b);
        requireMore(0);
        return std::int32_t(b[0] | b[1] << 8 | b[2] << 16 | std::uint32_t(b[3]) << 24);
    }

    int byte() {
        const int value = file_.get();
        requireMore(0);
        return value;
    }

    void skip(std::int64_t bytes) {
        requireMore(bytes);
        file_.seekg(bytes, std::ios::cur);
    }

    bool atEndOfHeader() {
        if (file_.peek() != 0) return false;
        file_.get();
        return true;
    }

    std::int64_t place() { return file_.tellg(); }
    void goTo(std::int64_t place) { file_.seekg(place); }

    void requireAt(std::int64_t end, const std::string& type) {
        if (place() != end) fail("its header has a value of type " + type + " that is not as long as it says");
    }

    void requireMore(std::int64_t bytes) {
        if (!file_ || bytes < 0 || bytes > length_ - place()) fail("its header is longer than the file");
    }

  private:
    std::string path_;
    std::ifstream file_;
    std::int64_t length_ = 0;
};

struct Part {
    std::int64_t width = 0, height = 0, tileWidth = 0, tileHeight = 0, chunks = 0;
    int linesOfChunk = 1;
};

/// Passes over a value as OpenEXR does: by what is in it, where that says how long it is.
void passValue(Reader& file, const std::string& type, std::int64_t length) {
    const std::int64_t end = file.place() + length;
    const auto fixed = kFixedLengths.find(type);
    if (fixed != kFixedLengths.end()) {
        file.skip(fixed->second);
    } else if (type == "chlist") {
        constexpr int kPixelTypes = 3;
        constexpr std::int64_t kRest = 12;
        while (!file.text().empty()) {
            const int samples = file.integer();
            if (samples < 0 || samples >= kPixelTypes)
                file.fail("its header has a channel of a type that is not known");
            file.skip(kRest);
        }
    } else if (type == "stringvector") {
        while (file.place() < end) file.skip(file.integer());
    } else if (type == "preview") {
        const std::int64_t width = std::uint32_t(file.integer()), height = std::uint32_t(file.integer());
        if (width > 0 && height > (1 << 30) / width) file.requireMore(-1);
        file.skip(4 * width * height);
    } else if (type == "floatvector") {
        file.skip(length - length % 4);
    } else {
        file.skip(length);
    }
    file.requireAt(end, type);
}

/// By the number of the compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB.
int linesOfChunk(int compression) {
    constexpr int kLines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    return compression >= 0 && compression < 10 ? kLines[compression] : 256;
}

void readAttribute(Reader& file, Part& part) {
    const std::string name = file.text(), type = file.text();
    const std::int64_t length = file.integer();
    file.requireMore(length);
    const std::int64_t begin = file.place();
    if (name == "dataWindow" && length == 16) {
        const std::int64_t left = file.integer(), top = file.integer();
        part.width = file.integer() - left + 1;
        part.height = file.integer() - top + 1;
    } else if (name == "tiles" && length == 9) {
        part.tileWidth = std::uint32_t(file.integer());
        part.tileHeight = std::uint32_t(file.integer());
    } else if (name == "compression" && length == 1) {
        part.linesOfChunk = linesOfChunk(file.byte());
    } else if (name == "chunkCount" && length == 4) {
        part.chunks = file.integer();
    }
    file.goTo(begin);
    passValue(file, type, length);
}

std::int64_t parts(std::int64_t whole, std::int64_t part) {
    return part > 0 ? (whole + part - 1) / part : 0;
}

/// Levels of tiles add to the first.
double fewestChunks(const Part& part) {
    if (part.tileWidth > 0)
        return double(parts(part.width, part.tileWidth)) * double(parts(part.height, part.tileHeight));
    return double(std::max(parts(part.height, part.linesOfChunk), part.chunks));
}

}  // namespace

void requireSoundExrHeader(const std::string& path) {
    Reader file(path);
    file.integer();  // the magic number
    const bool several = (file.integer() & kSeveralParts) != 0;
    double chunks = 0;
    do {
        Part part;
        while (!file.atEndOfHeader()) readAttribute(file, part);
        chunks += fewestChunks(part);
    } while (several && !file.atEndOfHeader());
    if (chunks * 8 > 1e15) file.fail("it claims to have more pixels than a file of its size can hold");
    file.requireMore(std::int64_t(chunks * 8));
}

}  // namespace raysweep
