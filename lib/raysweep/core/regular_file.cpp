#include "raysweep/core/regular_file.h"

#include <filesystem>
#include <system_error>

namespace fs = std::filesystem;

namespace raysweep {

std::string whyNotRegular(const std::string& path, const std::string& wanted) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) return "there is no such file";
    if (error) return error.message();
    if (fs::is_directory(status)) return "it is a folder; give " + wanted;
    if (!fs::is_regular_file(status))
        return "it is a device or a pipe, not a regular file; save what it gives in a file first";
    return "";
}

}  // namespace raysweep
