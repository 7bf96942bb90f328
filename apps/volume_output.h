/// Outputs that are volumes, whose ending says of what kind.
#pragma once

#include <string>

namespace raysweep::apps {

bool isVdb(const std::string& path);

/// What --output names must be a .vdb or a dense file (dense_files.h). @throw CLI::ValidationError
void requireVolumeOutput(const std::string& path);

}  // namespace raysweep::apps
