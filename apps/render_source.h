/// What `raysweep render` shows: the file and what of it.
#pragma once

#include "transfer_options.h"

#include "raysweep/render/lit_volume.h"

#include <optional>
#include <string>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct RenderSource {
    std::string input, density, unshot;
    TransferArguments transfer;
    std::optional<double> extinction;
};

void addRenderSource(CLI::App& app, RenderSource& source);

/// Checks what can be checked without the file. @throw CLI::ValidationError
void requireRenderSource(const RenderSource& source, const CLI::App& command);

/// Reads the file and finds the grids; what the user leaves open is as it was when the file was lit.
/// @throw IoError, InvalidArgument
RenderInput renderInput(const RenderSource& source);

}  // namespace raysweep::apps
