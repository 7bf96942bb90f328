#include "raysweep/core/text_file.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"

#include <filesystem>
#include <fstream>
#include <sstream>

namespace fs = std::filesystem;

namespace raysweep {

std::string bytesOfFile(const std::string& path, const std::string& wanted) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw IoError("there is no such file");
    if (fs::is_directory(path, ignored)) throw IoError("it is a folder; give " + wanted);
    std::ifstream in(path, std::ios::binary);
    std::ostringstream bytes;
    bytes << in.rdbuf();
    if (!in) throw IoError("reading failed; may it be read?");
    return bytes.str();
}

void writeText(OutputFile& file, const std::string& text) {
    std::ofstream out(file.temporary(), std::ios::binary);
    out << text;
    out.close();
    if (!out) throw IoError("cannot write '" + file.target() + "': writing failed; is the disk full?");
}

void writeText(const std::string& path, const std::string& text) {
    OutputFile file(path);
    writeText(file, text);
    file.commit();
}

}  // namespace raysweep
