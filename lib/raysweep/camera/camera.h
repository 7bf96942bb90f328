/// Cameras: from a pixel to a ray.
#pragma once

#include "raysweep/core/types.h"

#include <ImathBox.h>

namespace raysweep {

using Box3 = Imath::Box<Vec3>;  ///< axis-aligned box, world units

/// A camera and the size of its picture. Pixels are square; world space is right-handed.
struct Camera {
    enum class Projection {
        Perspective,  ///< rays leave `eye`
        Orthographic  ///< parallel rays leave the plane through `eye`; what lies behind that plane is not seen
    };
    Projection projection = Projection::Perspective;
    Vec3 eye = Vec3(0, -5, 0);    ///< world units
    Vec3 target = Vec3(0, 0, 0);  ///< the point in the middle of the picture, world units
    Vec3 up = Vec3(0, 0, 1);      ///< points up in the picture; any length, not along the view
    double fov = 40;              ///< perspective: angle between top and bottom edge, degrees, in (0,180)
    double orthoWidth = 2;        ///< orthographic: width of the picture, world units, above 0
    int width = 512;              ///< pixels, above 0
    int height = 512;             ///< pixels, above 0

    /// @throw InvalidArgument that names field, value and bound.
    void validate() const;
};

/// Half-line from `origin`; `direction` has length 1. World units.
struct Ray {
    Vec3 origin;
    Vec3 direction;
};

/// A camera made ready for many rays.
struct CameraFrame {
    Camera::Projection projection;
    Vec3 eye;
    Vec3 forward;       ///< length 1
    Vec3 right;         ///< from the middle of the picture to its right edge: at distance 1, or in world units
    Vec3 up;            ///< from the middle of the picture to its top edge, likewise
    int width, height;  ///< pixels
};

/// @throw InvalidArgument as Camera::validate.
CameraFrame cameraFrame(const Camera& camera);

/// The ray through the point (x,y) of the picture: (0,0) is its top left corner, (width,height) its bottom right one,
/// so the middle of pixel (i,j) is (i+0.5, j+0.5).
inline Ray pixelRay(const CameraFrame& frame, double x, double y) {
    const Vec3 offset = frame.right * (2 * x / frame.width - 1) + frame.up * (1 - 2 * y / frame.height);
    if (frame.projection == Camera::Projection::Orthographic) return {frame.eye + offset, frame.forward};
    return {frame.eye, (frame.forward + offset).normalized()};
}

/// The camera carried around its target by `angle` radians about the axis `up`, counter-clockwise seen from the tip
/// of `up`. N pictures with angle 2 pi i / N make a turntable. @throw InvalidArgument as Camera::validate.
Camera orbit(const Camera& camera, double angle);

/// `camera` moved so that it sees the whole of `bounds`, nearly filling the picture: it looks at the middle of the
/// box, in a three-quarter view from the front, right and above. Projection, fov, up and size are kept, orthoWidth is
/// set. With +z up (the default, as in Blender and as for the sky) the front is -y; with +y up it is +z.
/// @throw InvalidArgument if up is 0, a field is out of its range, or bounds are empty or not finite.
Camera framed(const Camera& camera, const Box3& bounds);

}  // namespace raysweep
