/// Rotations from files. For this module's own sources.
#pragma once

#include "raysweep/camera/poses.h"

#include <array>

namespace raysweep {

/// The axes of a camera in world space, as a file has them: x, y, z.
using FileAxes = std::array<Vec3, 3>;

/// Sets right, down and forward. What differs from a rotation by more than rounding is replaced by the nearest one; if
/// it is one, its bits are kept.
/// @throw IoError if it differs by more than 1e-3, or mirrors
void setAxes(PhotoCamera& camera, const FileAxes& axes, CameraAxes convention);

/// Sets position too, of a file that says where the camera sees a point X: at R X + t, the rows of R being `axes`.
/// @throw IoError as setAxes
void setWorldToCamera(PhotoCamera& camera, const FileAxes& axes, const Vec3& translation, CameraAxes convention);

}  // namespace raysweep
