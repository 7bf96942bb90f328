/// By which options of a subcommand an error's remedy is asked for.
#pragma once

#include "raysweep/core/error.h"

#include <CLI/CLI.hpp>

#include <string>

namespace raysweep::apps {

/// The error's message in words of `command`: fields of the library's options are called as typed ("--density"), and
/// what helps is said by its options, if it has any for that.
std::string inWordsOf(const CLI::App& command, const Error& error);

}  // namespace raysweep::apps
