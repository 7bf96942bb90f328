#include "raysweep/core/target_path.h"

#include "raysweep/core/error.h"

#include <sys/stat.h>

#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

/// Linux shows open files as links, of which some say a name where there is no file.
bool isStream(const fs::path& path) {
    const fs::path folder = path.parent_path();
    return folder.filename() == "fd" && folder.string().rfind("/proc/", 0) == 0;
}

/// Where it is, without links, "." and "..", and without a slash at its end; the text itself where that cannot be told.
fs::path placeOf(const std::string& path) {
    std::error_code failed;
    fs::path place;
    try {
        place = fs::weakly_canonical(fs::absolute(throughLinks(path), failed), failed);
    } catch (const IoError&) {
        return path;
    }
    if (failed) place = fs::path(path).lexically_normal();
    return place.has_filename() ? place : place.parent_path();
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

bool sameFile(const std::string& a, const std::string& b) {
    struct stat inodeA, inodeB;
    const bool existsA = ::stat(a.c_str(), &inodeA) == 0, existsB = ::stat(b.c_str(), &inodeB) == 0;
    if (existsA && existsB) return inodeA.st_dev == inodeB.st_dev && inodeA.st_ino == inodeB.st_ino;
    return placeOf(a) == placeOf(b);
}

bool isWithin(const std::string& path, const std::string& folder) {
    const fs::path from = placeOf(path).lexically_relative(placeOf(folder));
    return !from.empty() && from != "." && *from.begin() != "..";
}

}  // namespace raysweep
