#include "raysweep/core/output_file.h"

#include "raysweep/core/error.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/core/target_path.h"
#include "raysweep/core/temporaries.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

constexpr mode_t kPermissions = S_IRWXU | S_IRWXG | S_IRWXO;

fs::path folderOf(const std::string& target) {
    const fs::path folder = fs::path(target).parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

[[noreturn]] void fail(const std::string& target, const std::string& why) {
    throw IoError("cannot write '" + target + "': " + why);
}

/// As new files have them.
mode_t newPermissions() {
    // The mask can only be read by setting it; files that other threads make meanwhile are closed to others.
    static const mode_t mask = [] {
        const mode_t now = ::umask(S_IRWXG | S_IRWXO);
        ::umask(now);
        return now;
    }();
    return (S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH) & ~mask;
}

/// Those of the file that will be replaced, or of a new one.
void takePermissions(int descriptor, const std::string& target) {
    struct stat old;
    const bool replaces = ::stat(target.c_str(), &old) == 0;
    // Only a privileged process may give a file to another owner. To another group it may not be open then.
    const bool given = replaces && ::fchown(descriptor, old.st_uid, old.st_gid) == 0;
    mode_t mode = replaces ? old.st_mode & kPermissions : newPermissions();
    struct stat own;
    if (replaces && !given && ::fstat(descriptor, &own) == 0 && own.st_gid != old.st_gid) mode &= ~mode_t(S_IRWXG);
    static_cast<void>(::fchmod(descriptor, mode));  // where there are no permissions (FAT) none are kept
}

/// What is there under the name, if anything, may be replaced.
void requireReplaceable(const std::string& target, const std::string& name) {
    struct stat found;
    std::error_code ignored;
    if (fs::is_symlink(target, ignored)) fail(name, "it is an open stream; give a file name");
    if (::stat(target.c_str(), &found) != 0) {
        if (errno == ENAMETOOLONG) fail(name, std::strerror(errno));
        return;
    }
    if (!S_ISREG(found.st_mode))
        fail(name, "it is not a regular file; give a file name (devices and pipes cannot be replaced by a whole file)");
    // A superuser may write to any file; one that is closed to everybody has been closed on purpose.
    constexpr mode_t kWrite = S_IWUSR | S_IWGRP | S_IWOTH;
    if ((found.st_mode & kWrite) == 0 || ::access(target.c_str(), W_OK) != 0)
        fail(name, "it is read-only; make it writable or choose another name");
    requireNotRead(target);
}

}  // namespace

void requireWritable(const std::string& name) {
    const std::string target = throughLinks(name);
    const fs::path folder = folderOf(target);
    std::error_code ignored;
    if (fs::path(target).filename().empty() || fs::is_directory(target, ignored))
        fail(name, "it names a folder; give a file name");
    if (!fs::is_directory(folder, ignored))
        fail(name, "the folder '" + folder.string() + "' does not exist; create it first");
    requireReplaceable(target, name);
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        fail(name, "no permission to write in the folder '" + folder.string() + "'");
}

OutputFile::OutputFile(const std::string& target) : target_(target) {
    requireWritable(target);
    const std::string real = throughLinks(target);
    try {
        temporary_ = makeTemporaryFile(folderOf(real).string(), fs::path(target).extension().string(), descriptor_);
    } catch (const IoError& e) {
        fail(target, e.what());
    }
}

OutputFile::~OutputFile() {
    ::close(descriptor_);
    if (!committed_) removeTemporary(temporary_);
}

void OutputFile::flush() {
    if (::fsync(descriptor_) != 0) fail(target_, std::strerror(errno));
}

void OutputFile::commit() {
    flush();
    const auto move = [name = target_, target = throughLinks(target_), temporary = temporary_] {
        if (const int why = moveTemporary(temporary, target)) fail(name, std::strerror(why));
    };
    takePermissions(descriptor_, throughLinks(target_));
    moveWithRun(move, temporary_);
    committed_ = true;
}

}  // namespace raysweep
