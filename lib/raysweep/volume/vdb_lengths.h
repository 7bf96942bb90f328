/// Lengths in a .vdb file, looked at before OpenVDB reads them: it makes room for as much as a damaged one says.
#pragma once

#include <cstdint>
#include <istream>
#include <string>

namespace raysweep {

/// The header and the file's metadata, from the file's start. Leaves the position as it was.
/// @param size of the file, bytes
/// @throw IoError if a text or value would be longer than the file, or the format's version is not known
void requireHeaderLengths(std::istream& in, std::uintmax_t size);

/// What a file says of a grid before the grid itself.
struct GridHead {
    std::string name, type;
    std::int64_t end = 0;  ///< where the grid ends in the file; 0 or less: not known
};

/// A grid's description, from the position on, which is left as it was. Its metadata and transform are looked at as
/// well, and of points what OpenVDB takes for granted.
/// @param version of the file's format
/// @param head gets what was read until something was wrong
/// @throw IoError as requireHeaderLengths does
void readGridHead(std::istream& in, std::uintmax_t size, std::uint32_t version, GridHead& head);

}  // namespace raysweep
