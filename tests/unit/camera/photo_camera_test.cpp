// Cameras of photographs: rays and projections are inverse to each other, whatever the lens.
#include "raysweep/camera/photo_camera.h"

#include "raysweep/core/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace raysweep;

namespace {

/// Looks from one corner of the world to another, so that no axis is one of the world's.
PhotoCamera askew() {
    PhotoCamera camera;
    camera.position = Vec3(3, -4, 2.5);
    camera.forward = (Vec3(0.2, 0.1, -0.3) - camera.position).normalized();
    camera.right = camera.forward.cross(Vec3(0.1, 0.2, 1)).normalized();
    camera.down = camera.forward.cross(camera.right);
    camera.focalX = 700;
    camera.focalY = 720;
    camera.principalX = 390;
    camera.principalY = 310;
    camera.width = 800;
    camera.height = 600;
    return camera;
}

PhotoCamera withDistortion(double k1, double k2, double p1, double p2) {
    PhotoCamera camera = askew();
    camera.distortion = {k1, k2, p1, p2};
    return camera;
}

/// Farthest that a pixel is from where a point of its ray is projected; the pixels cover the picture and its edges.
double worstRoundTrip(const PhotoCamera& camera) {
    double worst = 0;
    for (int y = 0; y <= 12; ++y)
        for (int x = 0; x <= 16; ++x)
            for (double distance : {0.1, 7.0}) {
                const double px = camera.width * x / 16.0, py = camera.height * y / 12.0;
                const Ray ray = pixelRay(camera, px, py);
                const auto seen = project(camera, ray.origin + ray.direction * distance);
                if (!seen) return std::numeric_limits<double>::infinity();
                worst = std::max(worst, std::hypot(seen->x - px, seen->y - py));
            }
    return worst;
}

}  // namespace

// Lenses from none over those of telephones to a wide one with 20 % of barrel at the picture's corners (the angle that
// folds back is beyond them); in pixels, so 1e-9 is 1e-12 of the focal length.
TEST(PhotoCamera, RaysAndProjectionsAreInverse) {
    const std::vector<PhotoCamera> cameras = {
        askew(),
        withDistortion(-0.3, 0.1, 0, 0),
        withDistortion(-0.28, 0.12, 0.002, -0.003),
        withDistortion(0.4, 0.3, -0.01, 0.02),
        withDistortion(-0.25, 0, 0, 0),
        withDistortion(0.3, -0.1, 0, 0),
    };
    for (const PhotoCamera& camera : cameras) {
        camera.validate();
        EXPECT_LT(worstRoundTrip(camera), 1e-9) << camera.distortion.k1 << " " << camera.distortion.k2;
    }
    PhotoCamera orthographic = askew();
    orthographic.projection = Camera::Projection::Orthographic;
    EXPECT_LT(worstRoundTrip(orthographic), 1e-9);
}

TEST(PhotoCamera, DistortionIsBrowns) {
    PhotoCamera camera = withDistortion(0.1, 0.02, 0.003, -0.004);
    const double x = 0.3, y = -0.2, r2 = x * x + y * y, radial = 1 + 0.1 * r2 + 0.02 * r2 * r2;
    const auto seen = project(camera, camera.position + camera.forward + camera.right * x + camera.down * y);
    ASSERT_TRUE(seen);
    // A few roundings of numbers of some hundred pixels.
    EXPECT_NEAR(seen->x, 390 + 700 * (x * radial + 2 * 0.003 * x * y - 0.004 * (r2 + 2 * x * x)), 1e-11);
    EXPECT_NEAR(seen->y, 310 + 720 * (y * radial + 0.003 * (r2 + 2 * y * y) - 2 * 0.004 * x * y), 1e-11);
    EXPECT_NEAR(seen->depth, 1, 1e-14);
}

// With k1 < 0 alone distortion turns back at r² = -1/(3 k1), where the picture shows r/1.5.
TEST(PhotoCamera, PointsThatDistortionWouldFoldBackAreNotSeen) {
    const PhotoCamera camera = withDistortion(-1.0 / 3, 0, 0, 0);
    const auto at = [&](double r) { return camera.position + camera.forward + camera.right * r; };
    EXPECT_TRUE(project(camera, at(0.999)));
    EXPECT_FALSE(project(camera, at(1.001)));
    EXPECT_FALSE(project(camera, at(50)));
    // No ray is shown farther out than 2/3; those asked for there come near the last one.
    const Ray beyond = pixelRay(camera, camera.principalX + 0.8 * camera.focalX, camera.principalY);
    // Near the turning point rays lie dense: 1e-3 of the angle moves the picture by 1e-6 of the focal length.
    EXPECT_NEAR(beyond.direction.dot(camera.right) / beyond.direction.dot(camera.forward), 1, 1e-3);
}

TEST(PhotoCamera, WhatIsBehindIsNotSeen) {
    for (auto projection : {Camera::Projection::Perspective, Camera::Projection::Orthographic}) {
        PhotoCamera camera = askew();
        camera.projection = projection;
        EXPECT_FALSE(project(camera, camera.position - camera.forward));
        EXPECT_FALSE(project(camera, camera.position));
        EXPECT_TRUE(project(camera, camera.position + camera.forward * 1e-3));
    }
}

TEST(PhotoCamera, IsTheSameAsTheCameraThatItIsMadeOf) {
    Camera camera;
    camera.eye = Vec3(2, -3, 4);
    camera.target = Vec3(0.5, 0.3, 0.2);
    camera.up = Vec3(0.1, 0, 3);
    camera.fov = 70;
    camera.orthoWidth = 3;
    camera.width = 320;
    camera.height = 200;
    for (auto projection : {Camera::Projection::Perspective, Camera::Projection::Orthographic}) {
        camera.projection = projection;
        const CameraFrame frame = cameraFrame(camera);
        const PhotoCamera photo = photoCamera(camera);
        photo.validate();
        EXPECT_EQ(photo.width, 320);
        EXPECT_EQ(photo.height, 200);
        EXPECT_NEAR(photo.focalX, photo.focalY, 1e-11) << "pixels are square";
        for (double x : {0.0, 0.5, 123.0, 320.0})
            for (double y : {0.0, 77.5, 200.0}) {
                const Ray expected = pixelRay(frame, x, y), ray = pixelRay(photo, x, y);
                // A few roundings of numbers below 10.
                EXPECT_LT((ray.origin - expected.origin).length(), 1e-14);
                EXPECT_LT((ray.direction - expected.direction).length(), 1e-14);
            }
    }
}

TEST(PhotoCamera, ResizedSeesTheSameInAnotherPicture) {
    const PhotoCamera camera = withDistortion(-0.2, 0.05, 0.001, 0.002), half = resized(camera, 400, 200);
    EXPECT_EQ(half.width, 400);
    EXPECT_EQ(half.height, 200);
    for (double x : {0.0, 100.0, 800.0})
        for (double y : {0.0, 300.0, 600.0}) {
            const Ray expected = pixelRay(camera, x, y), ray = pixelRay(half, x / 2, y / 3);
            // Distortion is undone to 1e-14 in both.
            EXPECT_LT((ray.direction - expected.direction).length(), 1e-13);
        }
    EXPECT_THROW(resized(camera, 0, 10), InvalidArgument);
}

TEST(PhotoCamera, ErrorsNameTheField) {
    const auto message = [](const std::function<void(PhotoCamera&)>& spoil) -> std::string {
        PhotoCamera camera = askew();
        spoil(camera);
        try {
            camera.validate();
        } catch (const InvalidArgument& error) {
            return error.what();
        }
        return "";
    };
    const auto expectNamed = [&](const std::string& name, const std::function<void(PhotoCamera&)>& spoil) {
        EXPECT_NE(message(spoil).find(name), std::string::npos) << name << " is not in: " << message(spoil);
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(message([](PhotoCamera&) {}), "");
    expectNamed("position", [&](PhotoCamera& c) { c.position.y = nan; });
    expectNamed("right", [](PhotoCamera& c) { c.right *= 1.001; });
    expectNamed("down", [&](PhotoCamera& c) { c.down.x = nan; });
    expectNamed("forward", [](PhotoCamera& c) { c.forward = -c.forward; });
    expectNamed("forward", [](PhotoCamera& c) { c.down = c.right; });
    expectNamed("focalX", [](PhotoCamera& c) { c.focalX = 0; });
    expectNamed("focalY", [&](PhotoCamera& c) { c.focalY = nan; });
    expectNamed("principalX", [&](PhotoCamera& c) { c.principalX = nan; });
    expectNamed("principalY", [&](PhotoCamera& c) { c.principalY = nan; });
    expectNamed("k2", [&](PhotoCamera& c) { c.distortion.k2 = nan; });
    expectNamed("width", [](PhotoCamera& c) { c.width = 0; });
    expectNamed("height", [](PhotoCamera& c) { c.height = -3; });
    expectNamed("orthographic", [](PhotoCamera& c) {
        c.projection = Camera::Projection::Orthographic;
        c.distortion.k1 = 0.1;
    });
}
