#include "raysweep/core/text_file.h"

#include "raysweep/core/error.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/run_outputs.h"

#include <cstdint>
#include <filesystem>
#include <fstream>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

constexpr std::uintmax_t kMostStreamed = std::uintmax_t(1) << 26;  ///< bytes of what has no end that is known

}  // namespace

std::string bytesOfFile(const std::string& path, const std::string& wanted) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw IoError("there is no such file");
    if (fs::is_directory(path, ignored)) throw IoError("it is a folder; give " + wanted);
    std::ifstream in(path, std::ios::binary);
    if (!in) throw IoError("reading failed; may it be read?");
    noteInput(path);
    const std::uintmax_t most = fs::is_regular_file(path, ignored) ? fs::file_size(path, ignored) : kMostStreamed;
    std::string bytes;
    constexpr std::size_t kPiece = std::size_t(1) << 20;
    while (in && bytes.size() <= most) {
        const std::size_t before = bytes.size();
        bytes.resize(before + kPiece);
        in.read(&bytes[before], std::streamsize(kPiece));
        bytes.resize(before + std::size_t(in.gcount()));
    }
    if (in.bad() || bytes.size() > most)
        throw IoError(in.bad() ? "reading failed; may it be read?" : "it does not end; give " + wanted);
    return bytes;
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
