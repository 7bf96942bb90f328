#include "raysweep/core/output_folder.h"

#include "raysweep/core/error.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/core/temporaries.h"

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <utility>

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

/// Takes the place of a folder that is there.
void moveFolder(const std::string& temporary, const std::string& target) {
    std::error_code ignored;
    const bool replaces = fs::exists(target, ignored);
    if (const int why = replaces ? exchangeTemporary(temporary, target) : moveTemporary(temporary, target))
        fail(target, std::strerror(why));
    if (replaces) removeTemporary(temporary);
}

}  // namespace

OutputFolder::OutputFolder(const std::string& target, std::function<bool(const std::string&)> isOurs)
    : isOurs_(std::move(isOurs)) {
    requireOurs(target, isOurs_);
    const fs::path path = plain(target), around = path.parent_path();
    std::error_code failed;
    if (!fs::is_directory(around, failed))
        fail(target, "the folder '" + around.string() + "' does not exist; create it first");
    if (::access(around.c_str(), W_OK | X_OK) != 0)
        fail(target, "no permission to write in the folder '" + around.string() + "'");
    target_ = path.string();
    try {
        temporary_ = makeTemporaryFolder(around.string());
    } catch (const IoError& e) {
        fail(target, e.what());
    }
}

OutputFolder::~OutputFolder() {
    if (!committed_) removeTemporary(temporary_);
}

void OutputFolder::commit() {
    const auto move = [temporary = temporary_, target = target_, isOurs = isOurs_] {
        requireOurs(target, isOurs);  // again: while the run went on, something may have been put there
        moveFolder(temporary, target);
    };
    moveWithRun(move, temporary_);
    committed_ = true;
}

}  // namespace raysweep
