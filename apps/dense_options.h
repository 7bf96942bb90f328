/// Options of subcommands that take a box of a grid's voxels: export, slices.
#pragma once

#include "cli.h"

#include "raysweep/formats/dense_source.h"

#include <optional>
#include <string>

namespace raysweep::apps {

/// What the user typed; empty text: not given.
struct DenseArguments {
    std::string grid, denseBox;
    std::optional<int> channel;
};

void addDenseOptions(CLI::App& app, DenseArguments& arguments);

/// The box that they mean, without looking into a file. @throw CLI::ValidationError
DenseChoice denseChoice(const DenseArguments& arguments);

/// What they mean of a .vdb file. @throw Error
DenseSource denseSource(const std::string& path, const DenseArguments& arguments);

}  // namespace raysweep::apps
