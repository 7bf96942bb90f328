/// Where the rays of a scan ran, from what is known of it: a file, or a turn about z.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/scan/projection_io.h"
#include "raysweep/scan/view_angles.h"

#include <optional>
#include <string>
#include <vector>

namespace raysweep {

/// What projections that are there say about their scan; 0 or empty: nothing.
struct MeasuredScan {
    int width = 0, height = 0, views = 0;
    std::optional<DetectorPair> spacing, origin;  ///< of the pixels, as ProjectionFile has them; world units
    std::vector<double> angles;                   ///< of each view, degrees
};

/// What is known of a scan beside its projections. What is not given is what they say, else has a default.
struct ScanGeometryOptions {
    std::string file;  ///< .json or RTK's .xml, see readGeometry; empty: a turn about the world's z axis, as follows
    BeamShape beam = BeamShape::parallel;
    double sourceToAxis = 0;      ///< cone: distance of source and axis, world units, > 0 (SID)
    double sourceToDetector = 0;  ///< cone: distance of source and detector, world units, > 0 (SDD)
    int views = 0;                ///< >= 0; 0: as many as projections
    double firstAngle = 0;        ///< degrees from +x towards +y; added to the angles that projections bring
    /// Degrees from the first view to where one after the last would be, not 0. Default: the angles that files
    /// bring, else 180 (parallel) or 360 (cone).
    std::optional<double> arc;
    std::string angles;                  ///< file with the angle of each view (readAngleFile); then without `arc`
    std::optional<AngleUnit> angleUnit;  ///< of the angles that files say; default: see viewAngles
    std::optional<double> axisColumn, centerRow;  ///< see CircularOrbit; default: the middle
    std::optional<Vec3> center;                   ///< point on the axis that the central ray passes; default: 0,0,0
    int width = 0, height = 0;                    ///< of the detector, pixels, >= 0; 0: as the projections
    /// Distance of columns and of rows, world units at the detector, > 0. Default: as the projections say, else 1. A
    /// .json file says it itself.
    std::optional<DetectorPair> pitch;

    /// @throw InvalidArgument naming field, value and bound, or what must be left out beside `file`.
    void validate() const;
};

/// The views of a scan. Without projections (a `measured` that says nothing) options must name views, width and height,
/// or a file must.
/// @throw InvalidArgument as ScanGeometryOptions::validate, and naming what is not known.
/// @throw Error as readGeometry.
ProjectionGeometry scanGeometry(const ScanGeometryOptions& options, const MeasuredScan& measured = {});

/// From pixel to pixel, along columns and rows of the first view's detector; world units.
DetectorPair pitchOf(const ProjectionGeometry& geometry);

}  // namespace raysweep
