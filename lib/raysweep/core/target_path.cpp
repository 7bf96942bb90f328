#include "raysweep/core/target_path.h"

#include "raysweep/core/error.h"

#include <sys/stat.h>

#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

/// Linux shows open files as links in /proc/PROCESS/fd, of which some say a name where there is no file.
bool isStream(const fs::path& path) {
    std::error_code ignored;
    const fs::path named = path.parent_path(), folder = fs::canonical(named.empty() ? "." : named, ignored);
    return folder.filename() == "fd" && folder.string().rfind("/proc/", 0) == 0;
}

/// Where it is, without links, "." and "..", and without a slash at its end; the text itself where that cannot be told.
std::string placeOf(const std::string& path) {
    std::error_code failed;
    fs::path place;
    try {
        place = fs::weakly_canonical(fs::absolute(throughLinks(path), failed), failed);
    } catch (const IoError&) {
        return path;
    }
    if (failed) place = fs::path(path).lexically_normal();
    return (place.has_filename() ? place : place.parent_path()).string();
}

}  // namespace

std::string throughLinks(const std::string& path) {
    constexpr int kMostLinks = 40;  // as Linux
    fs::path at = path;
    std::error_code ignored;
    for (int links = 0; fs::is_symlink(at, ignored) && !isStream(at); ++links) {
        const fs::path to = fs::read_symlink(at, ignored);
        if (ignored || links == kMostLinks) throw IoError("'" + path + "' is a link that leads nowhere");
        at = to.is_absolute() ? to : at.parent_path() / to;
    }
    return at.string();
}

FileIdentity::FileIdentity(const std::string& path) : place_(placeOf(path)), key_(place_) {
    struct stat found;
    if (::stat(place_.c_str(), &found) == 0)
        key_ = "inode " + std::to_string(found.st_dev) + " " + std::to_string(found.st_ino);
}

bool FileIdentity::isWithin(const FileIdentity& folder) const {
    const fs::path from = fs::path(place_).lexically_relative(folder.place_);
    return !from.empty() && from != "." && *from.begin() != "..";
}

}  // namespace raysweep
