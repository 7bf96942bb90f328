/// Files that poses name. For this module's own sources.
#pragma once

#include <string>
#include <vector>

namespace raysweep {

/// Where pictures are looked for.
struct PictureFolders {
    std::string given;                 ///< by who calls: first, and there without the names' folders too; may be empty
    std::vector<std::string> folders;  ///< then in these, in this order
};

/// The file that `name` stands for, with or without its extension. @throw IoError that says where it was looked for
std::string findPicture(const PictureFolders& folders, const std::string& name);

}  // namespace raysweep
