// ITU-T T.81, annex B: a JPEG is a row of segments, each a mark FF xx and with a length; behind those that start a
// scan come coded data, in which FF is followed by 00 or by a restart mark.
#include "raysweep/image/jpeg_check.h"

#include <fstream>

namespace raysweep {
namespace {

constexpr int kStart = 0xD8, kEnd = 0xD9;

bool isRestart(int mark) {
    return mark >= 0xD0 && mark <= 0xD7;
}

/// Goes on to behind the next mark, through coded data and filling. @return the mark, or -1 if the file ends before
int nextMark(std::istream& file) {
    for (int byte; (byte = file.get()) != EOF;) {
        if (byte != 0xFF) continue;
        while ((byte = file.get()) == 0xFF) continue;
        if (byte != 0 && !isRestart(byte)) return byte;
    }
    return -1;
}

}  // namespace

bool isCutJpeg(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (file.get() != 0xFF || file.get() != kStart || file.get() != 0xFF) return false;
    file.unget();
    for (;;) {
        const int mark = nextMark(file);
        if (mark == kEnd) return false;
        if (mark < 0) return true;
        const int high = file.get(), low = file.get();
        if (low == EOF) return true;
        file.seekg(256 * high + low - 2, std::ios::cur);  // reading behind the end fails later
    }
}

}  // namespace raysweep
