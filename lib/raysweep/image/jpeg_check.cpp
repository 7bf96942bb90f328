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
int nextMark(std::filebuf& file) {
    for (int byte; (byte = file.sbumpc()) != EOF;) {
        if (byte != 0xFF) continue;
        while ((byte = file.sbumpc()) == 0xFF) continue;
        if (byte != 0 && !isRestart(byte)) return byte;
    }
    return -1;
}

}  // namespace

bool isCutJpeg(const std::string& path) {
    std::filebuf file;
    if (!file.open(path, std::ios::in | std::ios::binary)) return false;
    if (file.sbumpc() != 0xFF || file.sbumpc() != kStart || file.sgetc() != 0xFF) return false;
    for (;;) {
        const int mark = nextMark(file);
        if (mark == kEnd) return false;
        if (mark < 0) return true;
        const int high = file.sbumpc(), low = file.sbumpc();
        if (low == EOF) return true;
        file.pubseekoff(256 * high + low - 2, std::ios::cur);  // reading behind the end fails later
    }
}

}  // namespace raysweep
