#include "raysweep/camera/picture_folders.h"

#include "raysweep/core/error.h"

#include <filesystem>

namespace fs = std::filesystem;

namespace raysweep {
namespace {

constexpr const char* kExtensions[] = {"",     ".png", ".jpg",  ".jpeg", ".exr", ".tif", ".tiff",
                                       ".hdr", ".PNG", ".JPEG", ".JPG",  ".TIF", ".TIFF"};

/// Empty if there is no such file.
std::string withSomeExtension(const fs::path& path) {
    for (const char* extension : kExtensions) {
        std::error_code ignored;
        const fs::path file = fs::path(path.string() + extension).lexically_normal();
        if (fs::is_regular_file(file, ignored)) return file.string();
    }
    return "";
}

}  // namespace

std::string findPicture(const PictureFolders& folders, const std::string& name) {
    std::vector<fs::path> candidates;
    if (!folders.given.empty()) {
        candidates.push_back(fs::path(folders.given) / name);
        candidates.push_back(fs::path(folders.given) / fs::path(name).filename());
    }
    for (const std::string& folder : folders.folders) candidates.push_back(fs::path(folder) / name);
    for (const fs::path& candidate : candidates)
        if (const std::string file = withSomeExtension(candidate); !file.empty()) return file;
    std::string where;
    if (!folders.given.empty()) where = "'" + folders.given + "'";
    for (const std::string& folder : folders.folders)
        where += (where.empty() ? "'" : ", '") + (folder.empty() ? "." : folder) + "'";
    throw IoError("there is no picture '" + name + "' (looked for in " + where + "); say in which folder it is");
}

}  // namespace raysweep
