/// Output that appears whole or not at all.
#pragma once

#include <string>

namespace raysweep {

/// A file being written beside its target under a temporary name. `commit` moves it into place; without it the
/// temporary is removed, and what stood under the target's name stays as it was.
class OutputFile {
  public:
    /// @throw IoError if the target's folder does not exist or cannot be written to, or the target is a folder.
    explicit OutputFile(const std::string& target);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// What it will be called.
    const std::string& target() const { return target_; }
    /// Where to write; it ends with the target's extension, so that writers that choose a format by name can.
    const std::string& temporary() const { return temporary_; }

    /// Brings the temporary to the disk, so that of several files that belong together none is committed while another
    /// may still fail. @throw IoError if that fails (disk full, for instance).
    void flush();
    /// Flushes the temporary and renames it. @throw IoError if either fails.
    void commit();

  private:
    std::string target_, temporary_;
    bool committed_ = false;
};

/// Checks that `target` could be written, so that long work does not end in an error that was certain at its start.
/// @throw IoError as OutputFile does.
void requireWritable(const std::string& target);

}  // namespace raysweep
