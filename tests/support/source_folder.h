/// Where the project's files are.
#pragma once

#include <string>

namespace raysweep::test {

/// The checkout that the tests were built from.
std::string sourceFolder();

}  // namespace raysweep::test
