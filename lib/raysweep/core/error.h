/// The two ways a call can fail. A message says what was wrong, where, and what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace raysweep {

struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An argument, option or voxel value that cannot be worked with.
struct InvalidArgument : Error {
    using Error::Error;
};

/// A file that cannot be read or written as asked.
struct IoError : Error {
    using Error::Error;
};

}  // namespace raysweep
