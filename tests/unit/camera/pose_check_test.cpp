// Cameras that look away from what they took pictures of.
#include "raysweep/camera/pose_check.h"

#include "support/volumes.h"
#include "unit/camera/pose_fixture.h"

#include <gtest/gtest.h>

using namespace raysweep;
using namespace raysweep::test;

namespace {

const Vec3 kMiddle(3, -2, 1);

CameraAxes other(CameraAxes axes) {
    return axes == CameraAxes::openGl ? CameraAxes::openCv : CameraAxes::openGl;
}

}  // namespace

TEST(PoseCheck, FindsAxesOfAnotherProgram) {
    for (auto projection : {Camera::Projection::Perspective, Camera::Projection::Orthographic})
        for (auto axes : {CameraAxes::openGl, CameraAxes::openCv}) {
            Poses good = posesOf(camerasAround(kMiddle, 10, 5, projection));
            good.axes = axes;
            Poses bad = withConvention(good, other(axes));
            for (int given = 0; given < 3; ++given) {  // nothing, points, bounds
                if (given == 1) good.points = bad.points = somePoints(kMiddle, 1, 200);
                if (given == 2) good.bounds = bad.bounds = Box3(kMiddle - Vec3(1), kMiddle + Vec3(1));
                EXPECT_TRUE(checkAxes(good).lookingAway.empty());
                EXPECT_FALSE(checkAxes(good).better);
                const AxesFinding finding = checkAxes(bad);
                EXPECT_EQ(finding.lookingAway.size(), 10u);
                EXPECT_EQ(finding.better, axes);
                EXPECT_TRUE(checkAxes(withConvention(bad, *finding.better)).lookingAway.empty());
            }
        }
}

TEST(PoseCheck, OneViewThatLooksAwayIsNamedAndNoConvention) {
    Poses poses = posesOf(camerasAround(kMiddle, 10, 5));
    PhotoCamera& camera = poses.views[6].camera;
    camera.forward = -camera.forward;
    camera.right = -camera.right;
    const AxesFinding finding = checkAxes(poses);
    EXPECT_EQ(finding.lookingAway, std::vector<std::size_t>{6});
    EXPECT_FALSE(finding.better);
}

TEST(PoseCheck, BoundsBesideEverythingAreNoOtherProgramsAxes) {
    const Poses poses = posesOf(camerasAround(kMiddle, 10, 5));
    const AxesFinding finding = checkAxes(poses, Box3(Vec3(100), Vec3(101)));
    EXPECT_EQ(finding.lookingAway.size(), 10u);
    EXPECT_FALSE(finding.better);
}

TEST(PoseCheck, ViewsThatAllRunOneWayAreLeftAlone) {
    Poses poses = posesOf(camerasAround(kMiddle, 1, 5));
    for (int n = 0; n < 3; ++n) {
        poses.views.push_back(poses.views[0]);
        poses.views.back().camera.position.x += n;
    }
    EXPECT_TRUE(checkAxes(poses).lookingAway.empty());
    EXPECT_FALSE(checkAxes(withConvention(poses, CameraAxes::openGl)).better);
}

TEST(PoseCheck, RealPosesAreRightAndFoundWrongIfTheyAre) {
    for (const char* name : {"photos/lego", "photos/temple"}) {
        const std::string path = findData(name);
        if (path.empty()) GTEST_SKIP() << name << " is not on this machine; set RAYSWEEP_DATA";
        const Poses poses = readPoses(path);
        EXPECT_TRUE(checkAxes(poses).lookingAway.empty());
        EXPECT_EQ(checkAxes(withConvention(poses, other(poses.axes))).better, poses.axes);
    }
}
