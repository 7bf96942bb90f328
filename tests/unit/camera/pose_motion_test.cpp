#include "raysweep/camera/pose_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raysweep/core/normal_equations.h"

using namespace raysweep;

namespace {

const Box3 kBox(Vec3(-1, -0.8, -0.7), Vec3(1.1, 0.9, 0.6));

PhotoCamera cameraAt(const Vec3& eye, Camera::Projection projection = Camera::Projection::Perspective) {
    Camera camera;
    camera.projection = projection;
    camera.eye = eye;
    camera.fov = 40;
    camera.orthoWidth = 3;
    camera.width = camera.height = 400;
    return photoCamera(camera);
}

/// Around the origin, at distance 4.
std::vector<PhotoCamera> camerasAround(int count, Camera::Projection projection) {
    std::vector<PhotoCamera> cameras;
    for (int n = 0; n < count; ++n) {
        const double z = 0.9 - 1.8 * n / count, r = std::sqrt(1 - z * z), angle = 2.399963 * n;
        cameras.push_back(cameraAt(Vec3(r * std::cos(angle), r * std::sin(angle), z) * 4.0, projection));
    }
    return cameras;
}

}  // namespace

TEST(NormalEquations, SolveLeastSquares) {
    const std::array<double, 3> truth{0.5, -2, 3};
    NormalEquations<3> equations;
    for (int n = 0; n < 7; ++n) {
        const std::array<double, 3> slopes{1, double(n), double(n * n % 5)};
        double value = 0;
        for (std::size_t c = 0; c < 3; ++c) value += slopes[c] * truth[c];
        equations.add(slopes, value, 1 + n);
    }
    const std::array<double, 3> x = equations.solved(0);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(x[c], truth[c], 1e-12);
}

TEST(NormalEquations, UnknownsOfNoEquationStay) {
    NormalEquations<3> equations;
    equations.add({1, 0, 1}, 3, 1);
    equations.add({1, 0, -1}, 1, 1);
    const std::array<double, 3> x = equations.solved(0);
    EXPECT_NEAR(x[0], 2, 1e-12);
    EXPECT_EQ(x[1], 0);
    EXPECT_NEAR(x[2], 1, 1e-12);
}

// A camera that goes along with all of space sees what it saw.
TEST(PoseMotion, MovesWithTheWorld) {
    const Vec3 about(0.2, -0.1, 0.3), point(0.4, 0.5, -0.6);
    const SpaceMotion motion{Vec3(0, 0, kPi / 2), Vec3(0.1, 0.2, 0.3), std::log(1.5)};
    const Vec3 arm = point - about, turned(-arm.y, arm.x, arm.z);
    const PhotoCamera camera = cameraAt(Vec3(3, 1, 2)), after = moved(camera, motion, about);
    EXPECT_NO_THROW(after.validate());
    const auto before = project(camera, point), now = project(after, about + turned * 1.5 + motion.shift);
    EXPECT_NEAR(before->x, now->x, 1e-9);
    EXPECT_NEAR(before->y, now->y, 1e-9);
    EXPECT_NEAR(angleBetween(camera, after), 90, 1e-9);
}

// A sideways shift moves what a parallel projection shows by as many pixels, all of it alike.
TEST(PoseMotion, InPixels) {
    const PhotoCamera camera = cameraAt(Vec3(3, 1, 2), Camera::Projection::Orthographic);
    const PhotoCamera after = moved(camera, {Vec3(0), camera.right * 0.03, 0}, Vec3(0));
    EXPECT_NEAR(motionInPicture(camera, after, kBox), 0.03 * camera.focalX, 1e-9);
    EXPECT_NEAR(angleBetween(camera, after), 0, 1e-12);
}

// What all cameras have in common goes; what one has for itself stays. Rounding alone is left.
TEST(PoseMotion, CommonMotionIsRemoved) {
    for (const auto projection : {Camera::Projection::Perspective, Camera::Projection::Orthographic}) {
        const std::vector<PhotoCamera> given = camerasAround(9, projection);
        const SpaceMotion common{Vec3(0.02, -0.01, 0.015), Vec3(-0.03, 0.02, 0.01),
                                 projection == Camera::Projection::Perspective ? 0.02 : 0};
        std::vector<PhotoCamera> own = given, cameras;
        own[4] = moved(given[4], {Vec3(0.02, 0.03, 0), Vec3(0), 0}, Vec3(0));
        for (const PhotoCamera& camera : own) cameras.push_back(moved(camera, common, kBox.center()));
        ASSERT_GT(motionInPicture(own[0], cameras[0], kBox), 2);
        removeCommonMotion(given, kBox, cameras);
        for (std::size_t n = 0; n < given.size(); ++n) EXPECT_LT(motionInPicture(own[n], cameras[n], kBox), 1e-3) << n;
    }
}
