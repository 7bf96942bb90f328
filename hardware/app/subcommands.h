/// The table of raysweep-cube4's subcommands.
#pragma once

#include "cli11.h"

namespace raysweep::apps {

/// Each adds its subcommand to `app`; the callback does the work, throws raysweep::Error on failure and sets `exitCode`
/// when it ends otherwise than with kDone.
void addCube4Render(CLI::App& app, int& exitCode);
void addCube4Illuminate(CLI::App& app, int& exitCode);
void addCube4Reconstruct(CLI::App& app, int& exitCode);
void addCube4Check(CLI::App& app, int& exitCode);

}  // namespace raysweep::apps
