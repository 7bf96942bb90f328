/// Raysweep's own geometry files, described in docs/ct.md.
#pragma once

#include "raysweep/camera/projection_geometry.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace raysweep {

/// Reads the text of a file. Nothing is guessed: a key that is missing, unknown, given twice or of the wrong type is an
/// error that names it.
/// @throw IoError if it is not what docs/ct.md says. @throw InvalidArgument if it is, but makes no sense (see
/// ProjectionGeometry::validate and CircularOrbit::validate).
ProjectionGeometry geometryFromJson(const std::string& text);

/// The views as such a file has them.
nlohmann::ordered_json jsonOfViews(const ProjectionGeometry& geometry);

/// The text of a file with explicit views, one in each line; `geometry` must be valid. Reading it again gives the same
/// bits.
std::string jsonOf(const ProjectionGeometry& geometry);

}  // namespace raysweep
