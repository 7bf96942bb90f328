#include "raysweep/camera/camera.h"
#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

using namespace raysweep;

namespace {

constexpr double kTolerance = 1e-12;  // a few roundings of doubles of size 1 to 10

void expectNear(const Vec3& a, const Vec3& b, double tolerance = kTolerance) {
    EXPECT_LT((a - b).length(), tolerance) << a << " and " << b;
}

Camera lookingAlongY(Camera::Projection projection) {
    Camera camera;
    camera.projection = projection;
    camera.eye = Vec3(1, -5, 2);
    camera.target = Vec3(1, 0, 2);
    camera.fov = 60;
    camera.orthoWidth = 8;
    camera.width = 200;
    camera.height = 100;
    return camera;
}

/// Where the camera sees `p`, in pixels.
std::pair<double, double> project(const CameraFrame& frame, const Vec3& p) {
    const Vec3 arm = p - frame.eye;
    const double depth = frame.projection == Camera::Projection::Perspective ? arm.dot(frame.forward) : 1.0;
    const double u = arm.dot(frame.right) / frame.right.length2() / depth;
    const double v = arm.dot(frame.up) / frame.up.length2() / depth;
    return {0.5 * frame.width * (1 + u), 0.5 * frame.height * (1 - v)};
}

}  // namespace

TEST(Camera, PerspectiveRaysSpanTheVerticalFieldOfView) {
    const CameraFrame frame = cameraFrame(lookingAlongY(Camera::Projection::Perspective));
    const Ray middle = pixelRay(frame, 100, 50), top = pixelRay(frame, 100, 0), left = pixelRay(frame, 0, 50);
    expectNear(middle.origin, Vec3(1, -5, 2));
    expectNear(middle.direction, Vec3(0, 1, 0));
    expectNear(top.direction, Vec3(0, std::cos(kPi / 6), std::sin(kPi / 6)));  // half of 60 degrees up
    const double edge = 2 * std::tan(kPi / 6);                                 // twice as wide as high
    expectNear(left.direction, Vec3(-edge, 1, 0).normalized());
}

TEST(Camera, OrthographicRaysAreParallelAndSpanTheWidth) {
    const CameraFrame frame = cameraFrame(lookingAlongY(Camera::Projection::Orthographic));
    for (double x : {0.0, 50.0, 200.0}) {
        const Ray ray = pixelRay(frame, x, 100);
        expectNear(ray.direction, Vec3(0, 1, 0));
        expectNear(ray.origin, Vec3(1 + 8 * (x / 200 - 0.5), -5, 2 - 2));
    }
}

TEST(Camera, UpNeedNotBeSquareToTheViewNorOfLengthOne) {
    Camera camera = lookingAlongY(Camera::Projection::Perspective);
    const Ray before = pixelRay(cameraFrame(camera), 30, 20);
    camera.up = Vec3(0, 3, 7);
    expectNear(pixelRay(cameraFrame(camera), 30, 20).direction, before.direction);
}

TEST(Camera, ErrorsNameTheField) {
    const auto message = [](const std::function<void(Camera&)>& spoil) -> std::string {
        Camera camera;
        spoil(camera);
        try {
            camera.validate();
        } catch (const InvalidArgument& e) {
            return e.what();
        }
        return "";
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto contains = [](const std::string& text, const char* word) {
        return text.find(word) != std::string::npos;
    };
    EXPECT_TRUE(contains(message([](Camera& c) { c.eye = c.target; }), "same point"));
    EXPECT_TRUE(contains(message([](Camera& c) { c.up = c.target - c.eye; }), "parallel"));
    EXPECT_TRUE(contains(message([](Camera& c) { c.up = Vec3(0); }), "up"));
    EXPECT_TRUE(contains(message([&](Camera& c) { c.eye.x = nan; }), "eye"));
    for (double fov : {0.0, 180.0, -1.0, nan}) EXPECT_TRUE(contains(message([&](Camera& c) { c.fov = fov; }), "fov"));
    EXPECT_TRUE(contains(message([](Camera& c) { c.width = 0; }), "width"));
    EXPECT_TRUE(contains(message([](Camera& c) { c.height = -1; }), "height"));
    EXPECT_TRUE(contains(message([](Camera& c) {
                             c.projection = Camera::Projection::Orthographic;
                             c.orthoWidth = 0;
                         }),
                         "orthoWidth"));
    EXPECT_EQ(message([](Camera&) {}), "");
}

TEST(Camera, OrbitTurnsAboutTheUpAxisThroughTheTarget) {
    Camera camera;
    camera.target = Vec3(1, 2, 3);
    camera.eye = Vec3(1, -2, 4);
    camera.up = Vec3(0, 0, 5);
    expectNear(orbit(camera, kPi / 2).eye, Vec3(5, 2, 4));  // counter-clockwise from above: from front to right
    expectNear(orbit(camera, 2 * kPi).eye, camera.eye);
    expectNear(orbit(orbit(camera, 1), -1).eye, camera.eye);
    camera.up = Vec3(1, 1, 1);
    EXPECT_NEAR((orbit(camera, 0.7).eye - camera.target).length(), std::sqrt(17), kTolerance);
}

TEST(Camera, FramedSeesTheWholeBoxAndLittleElse) {
    const Box3 bounds(Vec3(-3, 10, 5), Vec3(4, 11, 17));
    for (auto projection : {Camera::Projection::Perspective, Camera::Projection::Orthographic})
        for (const Vec3& up : {Vec3(0, 0, 1), Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(0.3, -0.2, -0.9)})
            for (int width : {100, 300}) {
                Camera camera = lookingAlongY(projection);
                camera.up = up;
                camera.width = width;
                camera.height = 200;
                camera = framed(camera, bounds);
                const CameraFrame frame = cameraFrame(camera);
                double nearest = 1e9;  // margin around the box, relative to the picture
                for (int corner = 0; corner < 8; ++corner) {
                    const auto [x, y] =
                        project(frame, Vec3(corner & 1 ? -3 : 4, corner & 2 ? 10 : 11, corner & 4 ? 5 : 17));
                    nearest = std::min({nearest, x / width, 1 - x / width, y / 200, 1 - y / 200});
                }
                EXPECT_GT(nearest, 0.01);
                EXPECT_LT(nearest, 0.06);
                EXPECT_GT((camera.eye - camera.target).dot(up), 0) << "seen from above";
            }
}

TEST(Camera, FramedNeedsABox) {
    EXPECT_THROW(framed(Camera(), Box3()), InvalidArgument);
    const Camera camera = framed(Camera(), Box3(Vec3(1), Vec3(1)));  // a point is a box too
    EXPECT_NO_THROW(camera.validate());
}
