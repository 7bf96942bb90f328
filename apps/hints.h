/// Errors of the library in words of a subcommand's options.
#pragma once

#include "raysweep/core/error.h"

#include "cli11.h"

#include <functional>
#include <string>

namespace raysweep::apps {

/// The error's message in words of `command`: fields of the library's options are called as typed ("--density") if it
/// has such options, and what helps is said by its options, if it has any for that.
std::string inWordsOf(const CLI::App& command, const Error& error);

/// Runs a check of the library's options. What it refuses is a usage error, and fields are called as typed
/// ("--dark: needs --flat as well") if they are options of `command`. @throw CLI::ValidationError
void requireValid(const CLI::App& command, const std::function<void()>& validate);

}  // namespace raysweep::apps
