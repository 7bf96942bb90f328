#include "raysweep/camera/camera.h"

#include "raysweep/core/directions.h"
#include "raysweep/core/error.h"
#include "raysweep/core/finite.h"
#include "raysweep/core/require.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace raysweep {
namespace {

template <class Value>
std::string text(const Value& value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

/// Everything but where the camera stands.
void requireLens(const Camera& camera) {
    requireField(camera.width > 0, "camera width", camera.width, "at least 1 pixel");
    requireField(camera.height > 0, "camera height", camera.height, "at least 1 pixel");
    if (camera.projection == Camera::Projection::Perspective)
        requireField(camera.fov > 0 && camera.fov < 180, "camera fov", camera.fov, "between 0 and 180 degrees");
    else
        requireField(camera.orthoWidth > 0 && std::isfinite(camera.orthoWidth), "camera orthoWidth", camera.orthoWidth,
                     "positive and finite");
    requireField(isDirection(camera.up), "camera up", camera.up, "finite and not zero");
}

/// Room left around the box, as a factor on its size in the picture.
constexpr double kMargin = 1.05;

/// A unit vector square to `up` that points to the right for someone who stands upright before the volume.
Vec3 rightOf(const Vec3& up) {
    const Vec3 axis = axisAside(up);
    return (axis - up * axis.dot(up)).normalized();
}

}  // namespace

void Camera::validate() const {
    requireLens(*this);
    requireField(isFinite(eye), "camera eye", eye, "finite");
    requireField(isFinite(target), "camera target", target, "finite");
    const Vec3 view = target - eye;
    requireField(isFinite(view), "camera eye", eye, "nearer to the target");
    if (!isDirection(view))
        throw InvalidArgument("camera eye and target are the same point " + text(eye) + ": move one of them");
    if (!(unitVector(view).cross(unitVector(up)).length() > 1e-6))
        throw InvalidArgument("camera up " + text(up) + " is parallel to the view from eye " + text(eye) +
                              " to target " + text(target) + ": give another up");
}

CameraFrame cameraFrame(const Camera& camera) {
    camera.validate();
    const Vec3 forward = unitVector(camera.target - camera.eye);
    const Vec3 right = forward.cross(unitVector(camera.up)).normalized();
    const double aspect = double(camera.width) / camera.height;
    const bool perspective = camera.projection == Camera::Projection::Perspective;
    const double top = perspective ? std::tan(camera.fov * kPi / 360) : 0.5 * camera.orthoWidth / aspect;
    return {camera.projection,          camera.eye,   forward,      right * (top * aspect),
            right.cross(forward) * top, camera.width, camera.height};
}

Camera orbit(const Camera& camera, double angle) {
    camera.validate();
    const Vec3 axis = unitVector(camera.up), arm = camera.eye - camera.target;
    Camera turned = camera;
    turned.eye = camera.target + arm * std::cos(angle) + axis.cross(arm) * std::sin(angle) +
                 axis * (axis.dot(arm) * (1 - std::cos(angle)));  // Rodrigues
    return turned;
}

Camera framed(const Camera& camera, const Box3& bounds) {
    requireLens(camera);
    if (bounds.isEmpty() || !isFinite(bounds.min) || !isFinite(bounds.max))
        throw InvalidArgument("bounds to frame are empty or not finite");
    const Vec3 up = unitVector(camera.up), right = rightOf(up), front = right.cross(up);
    Camera result = camera;
    result.target = bounds.center();
    result.eye = result.target + (right * 0.5 + front * 0.8 + up * 0.4).normalized();
    const CameraFrame frame = cameraFrame(result);
    const double aspect = double(camera.width) / camera.height, top = std::tan(camera.fov * kPi / 360);
    double distance = 0, height = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p = Vec3(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                            corner & 4 ? bounds.max.z : bounds.min.z) -
                       result.target;
        const double x = std::abs(p.dot(frame.right.normalized())), y = std::abs(p.dot(frame.up.normalized()));
        height = std::max({height, y, x / aspect});
        distance = std::max(distance, kMargin * std::max(y, x / aspect) / top - p.dot(frame.forward));
    }
    const double size = bounds.size().length();
    if (camera.projection == Camera::Projection::Orthographic) {
        distance = size;
        result.orthoWidth = size > 0 ? 2 * kMargin * height * aspect : 1;
    }
    // A box that is a single point still needs some distance to be looked at from.
    result.eye = result.target - frame.forward * (distance > 0 ? distance : 1.0);
    return result;
}

}  // namespace raysweep
