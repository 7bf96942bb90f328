/// Errors of the library in words of a subcommand's options.
#pragma once

#include "raysweep/core/error.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <string>

namespace raysweep::apps {

/// The error's message in words of `command`: fields of the library's options are called as typed ("--density"), and
/// what helps is said by its options, if it has any for that.
std::string inWordsOf(const CLI::App& command, const Error& error);

/// Runs a check of the library's options. What it refuses is a usage error, and its field is called as typed
/// ("--spacing 0: must be positive and finite") if it is an option of `command`. @throw CLI::ValidationError
void requireValid(const CLI::App& command, const std::function<void()>& validate);

}  // namespace raysweep::apps
