/// Cameras of photographs: intrinsics, pose and lens distortion.
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/core/types.h"

#include <optional>

namespace raysweep {

/// Brown's lens distortion, as in OpenCV's model of four coefficients. With x, y the undistorted coordinates at
/// distance 1 and r² = x² + y², the picture shows the point at x (1 + k1 r² + k2 r⁴) + 2 p1 x y + p2 (r² + 2 x²), y (1
/// + k1 r² + k2 r⁴) + p1 (r² + 2 y²) + 2 p2 x y.
struct Distortion {
    double k1 = 0, k2 = 0;  ///< radial
    double p1 = 0, p2 = 0;  ///< tangential

    bool isNone() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0; }
};

/// A camera that took a picture: what `Camera` looks at, but with any intrinsics. `right`, `down` and `forward` have
/// length 1, are at right angles, and right × down = forward.
struct PhotoCamera {
    Camera::Projection projection = Camera::Projection::Perspective;
    Vec3 position{0};  ///< perspective: centre of projection; orthographic: a point of the picture's plane, behind
                       ///< which nothing is seen; world units
    Vec3 right{1, 0, 0}, down{0, 0, -1}, forward{0, 1, 0};  ///< world space
    double focalX = 0, focalY = 0;                          ///< pixels, > 0; orthographic: pixels per world unit
    double principalX = 0, principalY = 0;  ///< where `forward` meets the picture, pixels from its top left corner
    Distortion distortion;                  ///< none if orthographic
    int width = 0, height = 0;              ///< pixels, > 0

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// `camera` as one of a photograph: the same rays. @throw InvalidArgument as Camera::validate.
PhotoCamera photoCamera(const Camera& camera);

/// The ray through the point (x,y) of the picture: (0,0) is its top left corner, (width,height) its bottom right one,
/// so the middle of pixel (i,j) is (i+0.5, j+0.5). Distortion is undone by iteration, to 1e-9 of the focal length.
/// Where it is so strong that no ray reaches the point, the ray is about the one that comes nearest.
Ray pixelRay(const PhotoCamera& camera, double x, double y);

/// Where a point of the world is seen.
struct Projected {
    double x, y;   ///< pixels, as for pixelRay; may lie outside the picture
    double depth;  ///< along `forward`, world units
};

/// Nothing for points that are not before the camera, nor for those so far aside that radial distortion would show them
/// again nearer to the middle: its coefficients say nothing about them.
std::optional<Projected> project(const PhotoCamera& camera, const Vec3& point);

/// A direction that is fixed to the camera, such as that of light from a lamp beside it: `direction` as it is for `to`
/// if it is so for `from`. Or camera and lamp stand still, and the object turns.
Vec3 carriedAlong(const Vec3& direction, const PhotoCamera& from, const PhotoCamera& to);

/// The same camera with a picture of another size. @throw InvalidArgument as PhotoCamera::validate, or if the size is
/// 0.
PhotoCamera resized(const PhotoCamera& camera, int width, int height);

}  // namespace raysweep
