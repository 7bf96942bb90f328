/// What a path names in the end.
#pragma once

#include <string>

namespace raysweep {

/// `path` itself, or what it stands for if it is a symbolic link, or a link to a link; that need not exist.
/// Links that Linux shows in place of a process's open files (/dev/stdout leads to one) are left.
/// @throw IoError if links go round in a circle
std::string throughLinks(const std::string& path);

/// True if both name one file or folder, however they are spelt: the same inode where there is one (symbolic and hard
/// links, file systems that do not tell small letters from capitals), else the same place after links, "." and "..".
bool sameFile(const std::string& a, const std::string& b);

/// True if `path` is in `folder`, or in a folder in it.
bool isWithin(const std::string& path, const std::string& folder);

}  // namespace raysweep
