#include "raysweep/core/output_folder.h"

#include "raysweep/core/error.h"

#include <unistd.h>

#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

[[noreturn]] void fail(const std::string& target, const std::string& why) {
    throw IoError("cannot write '" + target + "': " + why);
}

/// Without a slash at its end, and what a link stands for.
fs::path plain(const std::string& target) {
    std::error_code failed;
    const fs::path real = fs::canonical(target, failed);
    if (!failed) return real;
    const fs::path path = fs::absolute(target).lexically_normal();
    return path.has_filename() ? path : path.parent_path();
}

void requireOurs(const std::string& target, const std::function<bool(const std::string&)>& isOurs) {
    std::error_code failed;
    if (!fs::exists(target, failed)) return;
    if (!fs::is_directory(target, failed)) fail(target, "it is a file; give a folder");
    for (const auto& entry : fs::directory_iterator(target, failed))
        if (!entry.is_regular_file(failed) || !isOurs(entry.path().filename().string()))
            fail(target, "it holds '" + entry.path().filename().string() +
                             "', which is not of such a folder's files, and it would be replaced as a whole; give "
                             "another folder");
    if (failed) fail(target, failed.message());
}

}  // namespace

OutputFolder::OutputFolder(const std::string& target, const std::function<bool(const std::string&)>& isOurs) {
    requireOurs(target, isOurs);
    const fs::path path = plain(target), around = path.parent_path();
    std::error_code failed;
    if (!fs::is_directory(around, failed))
        fail(target, "the folder '" + around.string() + "' does not exist; create it first");
    if (::access(around.c_str(), W_OK | X_OK) != 0)
        fail(target, "no permission to write in the folder '" + around.string() + "'");
    target_ = path.string();
    temporary_ = (around / ("." + path.filename().string() + ".part" + std::to_string(::getpid()))).string();
    if (!fs::create_directory(temporary_, failed)) fail(target, failed ? failed.message() : "it is being written");
}

OutputFolder::~OutputFolder() {
    std::error_code ignored;
    if (!committed_) fs::remove_all(temporary_, ignored);
}

void OutputFolder::commit() {
    std::error_code failed, ignored;
    const std::string old = temporary_ + ".old";
    const bool replaces = fs::exists(target_, ignored);
    if (replaces) fs::rename(target_, old, failed);
    if (failed) fail(target_, failed.message());
    fs::rename(temporary_, target_, failed);
    if (failed) {
        if (replaces) fs::rename(old, target_, ignored);
        fail(target_, failed.message());
    }
    committed_ = true;
    if (replaces) fs::remove_all(old, ignored);
}

}  // namespace raysweep
