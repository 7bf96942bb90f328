#include "raysweep/core/output_file.h"

#include "raysweep/core/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

fs::path folderOf(const std::string& target) {
    const fs::path folder = fs::path(target).parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

[[noreturn]] void fail(const std::string& target, const std::string& why) {
    throw IoError("cannot write '" + target + "': " + why);
}

}  // namespace

void requireWritable(const std::string& target) {
    const fs::path folder = folderOf(target);
    std::error_code ignored;
    if (fs::path(target).filename().empty() || fs::is_directory(target, ignored))
        fail(target, "it names a folder; give a file name");
    if (fs::exists(target, ignored) && !fs::is_regular_file(target, ignored))
        fail(target, "it is not a regular file; give a file name");
    if (!fs::is_directory(folder, ignored))
        fail(target, "the folder '" + folder.string() + "' does not exist; create it first");
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        fail(target, "no permission to write in the folder '" + folder.string() + "'");
}

OutputFile::OutputFile(const std::string& target) : target_(target) {
    requireWritable(target);
    const fs::path path(target);
    temporary_ = (folderOf(target) /
                  ("." + path.stem().string() + ".part" + std::to_string(::getpid()) + path.extension().string()))
                     .string();
}

OutputFile::~OutputFile() {
    std::error_code ignored;
    if (!committed_) fs::remove(temporary_, ignored);
}

void OutputFile::flush() {
    const int file = ::open(temporary_.c_str(), O_RDONLY);
    if (file < 0) fail(target_, std::strerror(errno));
    const int synced = ::fsync(file);
    const int why = errno;
    ::close(file);
    if (synced != 0) fail(target_, std::strerror(why));
}

void OutputFile::commit() {
    flush();
    if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(target_, std::strerror(errno));
    committed_ = true;
}

}  // namespace raysweep
