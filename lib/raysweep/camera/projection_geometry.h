/// X-ray views: where the ray of each detector pixel runs.
#pragma once

#include "raysweep/core/types.h"

#include <optional>
#include <vector>

namespace raysweep {

enum class BeamShape {
    parallel,  ///< all rays of a view run along `XrayView::direction`
    cone       ///< all rays of a view leave `XrayView::source`
};

/// One exposure of a flat detector. World units.
struct XrayView {
    Vec3 source{0};     ///< cone: the point that rays leave
    Vec3 direction{0};  ///< parallel: where rays run to, length 1
    Vec3 origin{0};     ///< centre of the pixel in column 0, row 0
    Vec3 column{0};     ///< from a pixel to the one in the next column
    Vec3 row{0};        ///< from a pixel to the one in the next row

    /// Centre of the pixel in column x, row y; need not be whole numbers.
    Vec3 pixel(double x, double y) const { return origin + column * x + row * y; }
};

/// Views by one detector.
struct ProjectionGeometry {
    BeamShape beam = BeamShape::parallel;
    int width = 0;   ///< detector columns
    int height = 0;  ///< detector rows
    std::vector<XrayView> views;

    /// @throw InvalidArgument if there is no view or no pixel, or naming the first view whose numbers are not finite,
    /// whose detector has no area, or whose rays run within the detector's plane.
    void validate() const;
};

constexpr int kMostViews = 1 << 20;  ///< of a turn: what is more was hardly meant

/// A turn about the world's z axis. At angle 0 the source is on the +x side, the detector on the -x side; the object
/// stands still and the source turns towards +y. Detector columns count towards +y at angle 0 (as seen from the source:
/// from left to right), rows towards -z (from top to bottom).
struct CircularOrbit {
    BeamShape beam = BeamShape::parallel;
    double sourceToAxis = 0;        ///< cone: distance of source and axis, world units, > 0 (SID)
    double sourceToDetector = 0;    ///< cone: distance of source and detector, world units, > 0 (SDD)
    int views = 180;                ///< 1 to kMostViews
    double firstAngle = 0;          ///< degrees
    double arc = 180;               ///< degrees from the first view to where one after the last would be, not 0
    std::vector<double> angles;     ///< of each view, degrees; given: `views`, `firstAngle` and `arc` are not looked at
    int width = 256, height = 256;  ///< pixels, > 0
    double pixelWidth = 1;          ///< distance of columns, world units at the detector, > 0
    double pixelHeight = 1;         ///< distance of rows, likewise
    /// Column onto which the axis falls, and row that the central ray, or the plane z = `center.z`, meets; 0 is the
    /// middle of the first, and both may lie off the detector. The middle, if not given.
    std::optional<double> axisColumn, centerRow;
    Vec3 center{0};  ///< point on the axis that the central ray passes, world units

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// @throw InvalidArgument as CircularOrbit::validate.
ProjectionGeometry circularGeometry(const CircularOrbit& orbit);

/// `geometry` without all views but `which`, in that order.
ProjectionGeometry selectViews(const ProjectionGeometry& geometry, const std::vector<int>& which);

}  // namespace raysweep
