#pragma once

#include <string>

namespace raysweep {

class OutputFile;

/// The bytes of a file. @param wanted what should have been given, for messages: "a geometry file (.json, or RTK's
/// .xml)". @throw IoError, which does not name the file, if there is none, it is a folder, reading fails,
/// or it is a device or pipe that gives more than 64 MiB, which may have no end
std::string bytesOfFile(const std::string& path, const std::string& wanted);

/// Writes a file that appears whole or not at all. @throw IoError
void writeText(const std::string& path, const std::string& text);
/// The same to a file that is yet to be committed.
void writeText(OutputFile& file, const std::string& text);

}  // namespace raysweep
