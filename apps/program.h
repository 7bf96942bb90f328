/// What a program's main() does, whatever its subcommands are.
#pragma once

#include "cli11.h"

namespace raysweep::apps {

/// Parses, runs the callback of the subcommand that was called, and makes messages and exit codes of what it throws.
/// @param exitCode what the callback sets when it ends otherwise than with kDone
int runProgram(CLI::App& app, int argc, char** argv, const int& exitCode);

}  // namespace raysweep::apps
