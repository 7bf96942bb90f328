/// What a header claims, before memory is taken for it.
#pragma once

#include "raysweep/core/error.h"

#include <string>

namespace raysweep {

/// No coding packs samples into less than this part of their size.
constexpr double kMostPacked = 1 << 17;

/// @param bytes of samples, unpacked, that the headers of files of `fileBytes` together promise
/// @throw IoError, which names `path`, if no file of that size can hold them
inline void requireRoom(const std::string& path, double bytes, double fileBytes) {
    if (!(bytes <= kMostPacked * fileBytes))
        throw IoError("cannot read '" + path +
                      "': it claims to have more pixels than a file of its size can hold; it is damaged");
}

}  // namespace raysweep
