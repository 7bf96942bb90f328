/// Where the project's files are.
#pragma once

#include <string>

namespace raysweep::test {

/// The checkout that the tests were built from.
std::string sourceFolder();

/// The folder that they were built in.
std::string buildFolder();

}  // namespace raysweep::test
