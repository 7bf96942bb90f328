/// Outputs of one run of a program, which appear together once it has succeeded.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace raysweep {

/// While one of these lives, output files and folders that are committed wait as temporaries, and files that are read
/// are remembered, so that none of them is replaced. Without one, as in programs that know what they do, outputs appear
/// when they are committed. There can be one at a time; what it is told may come from any thread.
class RunOutputs {
  public:
    RunOutputs();
    /// What waits is removed, and so are folders that were made for it.
    ~RunOutputs();
    RunOutputs(const RunOutputs&) = delete;
    RunOutputs& operator=(const RunOutputs&) = delete;
};

/// What waits takes its place, in the order in which it was committed. Whoever writes a series calls it after each of
/// its members. @throw IoError if a file cannot be moved; those after it are removed with the RunOutputs
void commitRunOutputs();

/// Remembers a file that will be replaced, so that it is not read.
void noteOutput(const std::string& target);

/// Remembers a file that is read. @throw IoError if it will be replaced
void noteInput(const std::string& path);

/// @throw IoError if `target` is a file that this run has read
void requireNotRead(const std::string& target);

/// Calls `move` when what waits takes its place; at once if there is no RunOutputs.
void moveWithRun(const std::function<void()>& move, const std::string& temporary);

/// Makes a folder, and those that it is in, for files to be written into. @throw IoError
void makeOutputFolder(const std::string& folder);

}  // namespace raysweep
