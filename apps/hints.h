/// By which options of a subcommand an error's remedy is asked for.
#pragma once

#include "raysweep/core/error.h"

#include <string>

namespace raysweep::apps {

/// The error's message, with what helps against it in words of the options of `command`, if that has any.
std::string withHint(const Error& error, const std::string& command);

}  // namespace raysweep::apps
