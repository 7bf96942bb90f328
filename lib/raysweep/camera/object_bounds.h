/// Where the object is that pictures show.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/camera/poses.h"

#include <optional>
#include <vector>

namespace raysweep {

/// The point with the least sum of distances to the lines through the middles of the pictures, so that a few that look
/// elsewhere do not matter; none if all are parallel, or nearly so (half a degree). World units.
std::optional<Vec3> middleOfViews(const std::vector<Pose>& views);

/// The box of most points: those that at least half of the views see (if that is enough of them), without the farthest
/// 1 % to either side of each axis, and with a margin of a tenth. None if there are fewer than 20.
std::optional<Box3> boundsOfPoints(const Poses& poses);

/// The box of all places that every view sees, around `middleOfViews`: an object that no picture cuts off is in it.
/// Views that do not see that point, or only near their edge, are left out.
/// @throw InvalidArgument if there is no such point, or less than half of the views see it
Box3 boundsSeenByAll(const std::vector<Pose>& views);

/// The file's bounds, else those of its points, else what all views see. @throw InvalidArgument as boundsSeenByAll
Box3 estimatedBounds(const Poses& poses);

/// The box of what the silhouettes leave of `start`: places that every photograph which shows them has its object at
/// (a visual hull of some 64 cells along the box's longest edge), and a cell around them. Never beyond `start`. What
/// lies beside a picture is empty, unless its object reaches its edge: then that picture says nothing about it. Where
/// less than a quarter of the photographs have their object is left out.
/// @throw InvalidArgument if `start` is empty or not finite, there is no photograph, one is not of its camera's size,
/// its matte is empty (it is named), or nothing is left
Box3 boundsOf(const std::vector<Photograph>& photographs, const Box3& start);

}  // namespace raysweep
