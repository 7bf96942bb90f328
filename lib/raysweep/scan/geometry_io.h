/// Where the rays ran, in files: our own JSON (docs/ct.md), and RTK's XML.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/scan/projection_io.h"

#include <optional>
#include <string>

namespace raysweep {

/// Reads `.json` (see geometryFromJson) or RTK's `.xml` (see geometryFromRtk). Only the latter needs to be told what
/// the detector is like; JSON says it itself.
/// @param width,height columns and rows of the detector.
/// @param spacing,origin of its pixels, as ProjectionFile has them; without an origin the detector's middle is at 0.
/// @throw InvalidArgument if the geometry makes no sense, or something that RTK's format leaves open is not given.
/// @throw IoError if the file is missing, malformed, or of another kind.
ProjectionGeometry readGeometry(const std::string& path, int width = 0, int height = 0,
                                const std::optional<DetectorPair>& spacing = {},
                                const std::optional<DetectorPair>& origin = {});

/// Writes JSON with one line for each view; the file appears whole or not at all.
/// @throw InvalidArgument as ProjectionGeometry::validate. @throw IoError if the file cannot be written.
void writeGeometry(const std::string& path, const ProjectionGeometry& geometry);

}  // namespace raysweep
