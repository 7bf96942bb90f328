/// Output that appears whole or not at all.
#pragma once

#include <string>

namespace raysweep {

/// A file being written beside its target under a temporary name. `commit` moves it into place (see RunOutputs: when
/// the run has succeeded); without it the temporary is removed, and what stood under the target's name stays as it was.
/// A target that is a symbolic link stays one: what it leads to is replaced. A file that is replaced hands on its
/// permissions, and its owner where the process may give files away.
class OutputFile {
  public:
    /// @throw IoError as requireWritable does
    explicit OutputFile(const std::string& target);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// What it will be called.
    const std::string& target() const { return target_; }
    /// Where to write; an empty file. It ends with the target's extension, so that writers that choose a format by name
    /// can.
    const std::string& temporary() const { return temporary_; }

    /// Brings the temporary to the disk, so that of several files that belong together none is committed while another
    /// may still fail. @throw IoError if that fails (disk full, for instance).
    void flush();
    /// Flushes the temporary and renames it. @throw IoError if either fails.
    void commit();

  private:
    std::string target_, temporary_;
    int descriptor_ = -1;
    bool committed_ = false;
};

/// Checks that `target` could be written, so that long work does not end in an error that was certain at its start.
/// @throw IoError if it is a folder, a device, a pipe, read-only or a file that this run has read, or if the folder it
/// would be in does not exist or cannot be written to
void requireWritable(const std::string& target);

}  // namespace raysweep
