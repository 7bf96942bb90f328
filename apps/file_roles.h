/// Which options name files, and that none that is written is read or written twice: said once, where the option is
/// added, and checked for every subcommand before it opens anything.
#pragma once

#include "cli11.h"

#include <functional>
#include <string>
#include <vector>

namespace raysweep::apps {

/// The files that an option's value stands for; none, if it is no name of a file.
using FileNames = std::function<std::vector<std::string>(const std::string& value)>;

/// Files or folders that are read. What is no name of a file ("0.5", "fbp") does no harm.
CLI::Option* reads(CLI::Option* option, FileNames names = {});
/// Files that are replaced.
CLI::Option* writes(CLI::Option* option, FileNames names = {});
/// A folder that files are written into; with `replaced` all that is in it goes.
CLI::Option* fills(CLI::Option* option, bool replaced = false);
/// A file, or a folder all of whose content goes: `isFolder` tells by the value.
CLI::Option* writesOrFills(CLI::Option* option, std::function<bool(const std::string& value)> isFolder);

/// For the values that `command` was given.
/// @throw CLI::ValidationError if an output is also an input, a config file or another output, a folder for output is
/// or holds an input, or a value is empty
void requireFilesApart(const CLI::App& command);

}  // namespace raysweep::apps
