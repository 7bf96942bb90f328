/// Whether cameras look at what they took pictures of.
#pragma once

#include "raysweep/camera/poses.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace raysweep {

struct AxesFinding {
    std::vector<std::size_t> lookingAway;  ///< views that see no part of the object's box
    std::optional<CameraAxes> better;      ///< the convention in which nearly all see it, if nearly none does now
};

/// Looks whether the views see the object: `bounds`, else those of the file, else where most points are, else the point
/// nearest to the middles of all views. Poses that were written with the axes of another program look away from it, all
/// of them; taken as the other convention's they look at it.
/// Nothing is found if there is nothing to look at: no bounds and points, and views that all run one way.
AxesFinding checkAxes(const Poses& poses, const std::optional<Box3>& bounds = {});

}  // namespace raysweep
