/// Geometry files of RTK, the reconstruction toolkit: ThreeDCircularProjectionGeometry in XML.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/scan/projection_io.h"

#include <optional>
#include <string>

namespace raysweep {

/// What RTK takes from the header of the projection images.
struct RtkDetector {
    int width = 0, height = 0;            ///< columns and rows, > 0
    std::optional<DetectorPair> spacing;  ///< from pixel to pixel, not 0; must be given
    std::optional<DetectorPair> origin;   ///< centre of the pixel (0,0); without it the detector's middle is at 0
};

/// Reads the text of a file of version 2 or 3, cone beam or parallel (SourceToDetectorDistance 0). The world is RTK's:
/// isocentre at 0, y the axis of rotation; at gantry angle 0 the source is on the +z side, detector columns count
/// towards +x and rows towards +y. Values hold until another one is given, as in RTK. <Matrix> is checked against the
/// view where there is one; the collimator's jaws are passed over.
/// Source: https://docs.openrtk.org, "3D projection geometry".
/// @throw IoError if the text is not XML, or not such a file. @throw InvalidArgument if the detector is not given or
/// curved, matrices contradict the other values, or a view makes no sense (see ProjectionGeometry::validate).
ProjectionGeometry geometryFromRtk(const std::string& text, const RtkDetector& detector);

}  // namespace raysweep
