/// What a path names in the end.
#pragma once

#include <string>

namespace raysweep {

/// `path` itself, or what it stands for if it is a symbolic link, or a link to a link; that need not exist.
/// Links that Linux shows in place of a process's open files (/dev/stdout leads to one) are left.
/// @throw IoError if links go round in a circle
std::string throughLinks(const std::string& path);

/// What tells files and folders apart, however they are spelt: the inode where there is one (symbolic and hard links,
/// file systems that do not tell small letters from capitals), else the place after links, "." and "..".
class FileIdentity {
  public:
    explicit FileIdentity(const std::string& path);
    bool operator==(const FileIdentity& other) const { return key_ == other.key_; }
    bool operator<(const FileIdentity& other) const { return key_ < other.key_; }
    /// True if it is in `folder`, or in a folder in it.
    bool isWithin(const FileIdentity& folder) const;

  private:
    std::string place_, key_;
};

}  // namespace raysweep
