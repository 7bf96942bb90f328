/// Where the axis of rotation falls onto the detector, from the projections alone.
#pragma once

#include "raysweep/camera/projections.h"

#include <vector>

namespace raysweep {

struct RotationCenter {
    double column = 0;  ///< onto which the axis falls; 0 is the middle of the first
    /// Eq. 8 of rotation_center.cpp: how much opposite views differ when mirrored about it, relative to what they vary
    /// by: 0 not at all, 1 as much as views that have nothing to do with each other.
    double mismatch = 0;
};

/// For a parallel beam and an axis along the detector's columns: finds the column about which views mirrored fit those
/// half a turn later best. Only what both see is compared, so the object may stick out of the view; the axis is looked
/// for where they share at least a quarter of the detector, from an eighth of its width to seven eighths. Against
/// noise, and where no view is exactly half a turn after another, views up to a degree apart, or the two nearest ones,
/// are taken together; details that move too far between them are smoothed away first. Rays that were not measured are
/// filled in.
/// @param angles of the views, degrees, in any order; they must span half a turn, or end at most one and a half steps
/// before: many views then say less than one view at the end would.
/// @throw InvalidArgument if there are not as many angles as views, the arc is too short, the detector has less than 16
/// columns, or opposite views have less than half of what is in them in common.
RotationCenter findRotationCenter(const Projections& projections, const std::vector<double>& angles);

}  // namespace raysweep
