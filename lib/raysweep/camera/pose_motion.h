/// Small motions of cameras, and how far they are seen to go.
#pragma once

#include "raysweep/camera/photo_camera.h"
#include "raysweep/core/types.h"

#include <array>
#include <vector>

namespace raysweep {

/// A motion of space about a point m: x goes to m + e^growth R (x - m) + shift, with R the turn. Pictures of parallel
/// projection do not show growth.
struct SpaceMotion {
    Vec3 turn{0};       ///< along its axis, as long as its angle in radians
    Vec3 shift{0};      ///< world units
    double growth = 0;  ///< logarithm of the factor
};

/// The camera after the motion about `about`; its lens stays the same.
PhotoCamera moved(const PhotoCamera& camera, const SpaceMotion& motion, const Vec3& about);

/// The camera where another is, seeing what is before that.
PhotoCamera withPose(const PhotoCamera& camera, const PhotoCamera& pose);

/// Angle of the turn from one camera's axes to another's, degrees.
double angleBetween(const PhotoCamera& from, const PhotoCamera& to);

/// How far the corners of a box move in the picture, root of the mean square, pixels of `from`. Corners that either
/// does not see are left out; infinite without any.
double motionInPicture(const PhotoCamera& from, const PhotoCamera& to, const Box3& box);

/// Moves all cameras in the same way, such that the pictures of a box move as little as they can: the sum over views of
/// how far (motionInPicture). If a few views have moved far and the others have not, these stay where they are. What
/// all have in common is no correction: an object and cameras that go along with it look the same.
/// @param given where each was before
void removeCommonMotion(const std::vector<PhotoCamera>& given, const Box3& box, std::vector<PhotoCamera>& cameras);

}  // namespace raysweep
