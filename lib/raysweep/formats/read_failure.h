/// How readers of volumes say what is wrong. For this module's own sources.
#pragma once

#include "raysweep/core/error.h"

#include <string>

namespace raysweep {

[[noreturn]] inline void failRead(const std::string& path, const std::string& why, Remedy remedy = Remedy::none) {
    throw IoError("cannot read '" + path + "': " + why, remedy);
}

}  // namespace raysweep
