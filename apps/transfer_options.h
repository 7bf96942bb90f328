/// The options --ramp and --transfer, which `light` and `render` share.
#pragma once

#include "cli.h"

#include "raysweep/scene/scene_io.h"

#include <optional>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct TransferArguments {
    std::string ramp, table;

    bool given() const { return !ramp.empty() || !table.empty(); }
};

/// Adds both; they exclude each other and `extinction`, the option that they stand for.
void addTransferOptions(CLI::App& app, TransferArguments& arguments, CLI::Option* extinction);

/// The ramp that was typed, if one was. @throw CLI::ValidationError
std::optional<Classification> parseRamp(const TransferArguments& arguments);

/// The function that was asked for, if one was. @throw CLI::ValidationError for the ramp, IoError for the file
std::optional<Classification> readTransfer(const TransferArguments& arguments);

}  // namespace raysweep::apps
