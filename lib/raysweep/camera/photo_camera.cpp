#include "raysweep/camera/photo_camera.h"

#include "raysweep/core/finite.h"
#include "raysweep/core/require.h"

#include <cmath>
#include <limits>

namespace raysweep {
namespace {

/// How far the axes may be from length 1 and right angles: what is left of a rotation that was read as floats.
constexpr double kAxesTolerance = 1e-6;

constexpr double kFarthest = std::numeric_limits<double>::infinity();

/// A point of the plane at distance 1 before the camera, x to the right and y down.
struct PlanePoint {
    double x, y;

    double length2() const { return x * x + y * y; }
};

/// Where the picture shows the point.
PlanePoint distorted(const Distortion& d, const PlanePoint& p) {
    const double r2 = p.length2(), radial = 1 + r2 * (d.k1 + r2 * d.k2);
    return {p.x * radial + 2 * d.p1 * p.x * p.y + d.p2 * (r2 + 2 * p.x * p.x),
            p.y * radial + d.p1 * (r2 + 2 * p.y * p.y) + 2 * d.p2 * p.x * p.y};
}

/// The square of the distance from the axis at which radial distortion turns back: farther points would be shown again
/// nearer to the middle. It is where 1 + 3 k1 r² + 5 k2 r⁴, the derivative of r (1 + k1 r² + k2 r⁴), is 0 first.
double turningPoint2(const Distortion& d) {
    const double a = 5 * d.k2, b = 3 * d.k1, discriminant = b * b - 4 * a;
    if (discriminant < 0 || (b >= 0 && a >= 0)) return kFarthest;
    // The smaller positive root of a t² + b t + 1, in the form that has no difference of near numbers and no a below
    // it.
    return b < 0 ? 2 / (-b + std::sqrt(discriminant)) : (-b - std::sqrt(discriminant)) / (2 * a);
}

/// One step of Newton's method for distorted(p) = p - `rest`.
PlanePoint newtonStep(const Distortion& d, const PlanePoint& p, const PlanePoint& rest) {
    const double r2 = p.length2(), radial = 1 + r2 * (d.k1 + r2 * d.k2), slope = 2 * (d.k1 + 2 * r2 * d.k2);
    const double xx = radial + p.x * p.x * slope + 2 * d.p1 * p.y + 6 * d.p2 * p.x;
    const double xy = p.x * p.y * slope + 2 * d.p1 * p.x + 2 * d.p2 * p.y;
    const double yy = radial + p.y * p.y * slope + 6 * d.p1 * p.y + 2 * d.p2 * p.x;
    const double determinant = xx * yy - xy * xy;
    return {(yy * rest.x - xy * rest.y) / determinant, (xx * rest.y - xy * rest.x) / determinant};
}

/// The point that the picture shows at `shown`. Newton's method with steps that are halved until they come nearer; for
/// points that no ray reaches, beyond where distortion turns back, it ends at about the nearest that one does.
PlanePoint undistorted(const Distortion& d, const PlanePoint& shown) {
    if (d.isNone()) return shown;
    constexpr int kMostSteps = 100, kMostHalvings = 30;
    constexpr double kEnough = 1e-14;  // of the focal length; a few roundings of numbers near 1
    const double farthest2 = turningPoint2(d);
    const auto restAt = [&](const PlanePoint& p) {
        const PlanePoint at = distorted(d, p);
        return PlanePoint{shown.x - at.x, shown.y - at.y};
    };
    PlanePoint p = shown, rest{};
    while (p.length2() >= farthest2) p = {0.5 * p.x, 0.5 * p.y};
    rest = restAt(p);
    for (int n = 0; n < kMostSteps && rest.length2() > kEnough * kEnough; ++n) {
        PlanePoint step = newtonStep(d, p, rest);
        bool nearer = false;
        for (int halving = 0; !nearer && halving < kMostHalvings; ++halving, step = {0.5 * step.x, 0.5 * step.y}) {
            const PlanePoint next{p.x + step.x, p.y + step.y}, nextRest = restAt(next);
            nearer = next.length2() < farthest2 && nextRest.length2() < rest.length2();
            if (nearer) p = next, rest = nextRest;
        }
        if (!nearer) break;
    }
    return p;
}

void requireAxes(const PhotoCamera& camera) {
    const auto requireUnit = [](const Vec3& axis, const char* field) {
        requireField(isFinite(axis) && std::abs(axis.length() - 1) <= kAxesTolerance, field, axis, "of length 1");
    };
    requireUnit(camera.right, "camera right");
    requireUnit(camera.down, "camera down");
    requireUnit(camera.forward, "camera forward");
    // This is so only if they are at right angles.
    requireField((camera.right.cross(camera.down) - camera.forward).length() <= 4 * kAxesTolerance, "camera forward",
                 camera.forward, "right x down");
}

}  // namespace

void PhotoCamera::validate() const {
    const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
    requireField(isFinite(position), "camera position", position, "finite");
    requireAxes(*this);
    requireField(positive(focalX), "camera focalX", focalX, "positive and finite");
    requireField(positive(focalY), "camera focalY", focalY, "positive and finite");
    requireField(std::isfinite(principalX), "camera principalX", principalX, "finite");
    requireField(std::isfinite(principalY), "camera principalY", principalY, "finite");
    requireField(std::isfinite(distortion.k1), "camera distortion k1", distortion.k1, "finite");
    requireField(std::isfinite(distortion.k2), "camera distortion k2", distortion.k2, "finite");
    requireField(std::isfinite(distortion.p1), "camera distortion p1", distortion.p1, "finite");
    requireField(std::isfinite(distortion.p2), "camera distortion p2", distortion.p2, "finite");
    if (projection == Camera::Projection::Orthographic && !distortion.isNone())
        throw InvalidArgument("camera distortion: an orthographic camera has no lens; it must be 0");
    requireField(width > 0, "camera width", width, "at least 1 pixel");
    requireField(height > 0, "camera height", height, "at least 1 pixel");
}

PhotoCamera photoCamera(const Camera& camera) {
    const CameraFrame frame = cameraFrame(camera);
    PhotoCamera photo;
    photo.projection = frame.projection;
    photo.position = frame.eye;
    photo.right = frame.right.normalized();
    photo.down = -frame.up.normalized();
    photo.forward = frame.forward;
    photo.focalX = 0.5 * frame.width / frame.right.length();
    photo.focalY = 0.5 * frame.height / frame.up.length();
    photo.principalX = 0.5 * frame.width;
    photo.principalY = 0.5 * frame.height;
    photo.width = frame.width;
    photo.height = frame.height;
    return photo;
}

Ray pixelRay(const PhotoCamera& camera, double x, double y) {
    const PlanePoint shown{(x - camera.principalX) / camera.focalX, (y - camera.principalY) / camera.focalY};
    if (camera.projection == Camera::Projection::Orthographic)
        return {camera.position + camera.right * shown.x + camera.down * shown.y, camera.forward};
    const PlanePoint p = undistorted(camera.distortion, shown);
    return {camera.position, (camera.forward + camera.right * p.x + camera.down * p.y).normalized()};
}

std::optional<Projected> project(const PhotoCamera& camera, const Vec3& point) {
    const Vec3 arm = point - camera.position;
    const double depth = arm.dot(camera.forward);
    if (!(depth > 0)) return std::nullopt;
    PlanePoint p{arm.dot(camera.right), arm.dot(camera.down)};
    if (camera.projection == Camera::Projection::Perspective) {
        p = {p.x / depth, p.y / depth};
        if (!camera.distortion.isNone()) {
            if (p.length2() >= turningPoint2(camera.distortion)) return std::nullopt;
            p = distorted(camera.distortion, p);
        }
    }
    return Projected{camera.principalX + camera.focalX * p.x, camera.principalY + camera.focalY * p.y, depth};
}

Vec3 carriedAlong(const Vec3& direction, const PhotoCamera& from, const PhotoCamera& to) {
    return to.right * direction.dot(from.right) + to.down * direction.dot(from.down) +
           to.forward * direction.dot(from.forward);
}

PhotoCamera resized(const PhotoCamera& camera, int width, int height) {
    camera.validate();
    requireField(width > 0, "camera width", width, "at least 1 pixel");
    requireField(height > 0, "camera height", height, "at least 1 pixel");
    const double scaleX = double(width) / camera.width, scaleY = double(height) / camera.height;
    PhotoCamera other = camera;
    other.focalX *= scaleX;
    other.focalY *= scaleY;
    other.principalX *= scaleX;
    other.principalY *= scaleY;
    other.width = width;
    other.height = height;
    return other;
}

}  // namespace raysweep
