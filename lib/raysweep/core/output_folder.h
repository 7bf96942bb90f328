/// A folder of output that appears whole or not at all.
#pragma once

#include <functional>
#include <string>

namespace raysweep {

/// A folder being filled beside its target under a temporary name. `commit` moves it into place (see RunOutputs: when
/// the run has succeeded); without it the temporary is removed with all that is in it. A folder that stands under the
/// target's name is replaced as a whole, and until then stays as it is; so it must hold nothing but files that `isOurs`
/// knows by their names.
class OutputFolder {
  public:
    /// @throw IoError if the folder around the target does not exist or cannot be written to, or if the target is a
    /// file, or holds anything else.
    OutputFolder(const std::string& target, std::function<bool(const std::string& name)> isOurs);
    ~OutputFolder();
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;

    /// Where to write.
    const std::string& temporary() const { return temporary_; }

    /// What was there is as it was if this fails. @throw IoError, also if there is now what is not of such a folder
    void commit();

  private:
    std::function<bool(const std::string& name)> isOurs_;
    std::string target_, temporary_;
    bool committed_ = false;
};

}  // namespace raysweep
