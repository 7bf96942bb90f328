// Where the object is: by cameras, points and silhouettes.
#include "raysweep/camera/object_bounds.h"

#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"
#include "support/expect_error.h"
#include "support/volumes.h"
#include "unit/camera/pose_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace raysweep;
using namespace raysweep::test;

namespace {

const Vec3 kMiddle(3, -2, 1);

/// Largest distance of a face of `a` from that of `b`.
double difference(const Box3& a, const Box3& b) {
    double worst = 0;
    for (int axis = 0; axis < 3; ++axis)
        worst = std::max({worst, std::abs(a.min[axis] - b.min[axis]), std::abs(a.max[axis] - b.max[axis])});
    return worst;
}

double longest(const Box3& box) {
    return std::max({box.size().x, box.size().y, box.size().z});
}

bool contains(const Box3& outer, const Box3& inner) {
    return outer.intersects(inner.min) && outer.intersects(inner.max);
}

Camera orthographicFrom(const Vec3& direction, const Vec3& up, int width, int height) {
    Camera camera;
    camera.projection = Camera::Projection::Orthographic;
    camera.eye = kMiddle + direction * 10;
    camera.target = kMiddle;
    camera.up = up;
    camera.width = width;
    camera.height = height;
    camera.orthoWidth = 0.1 * width;
    return camera;
}

bool meetsBall(const Ray& ray, const Vec3& center, double radius) {
    const Vec3 arm = center - ray.origin;
    return arm.dot(ray.direction) > 0 && arm.cross(ray.direction).length() < radius;
}

bool meetsBox(const Ray& ray, const Box3& box) {
    double enter = 0, leave = 1e300;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = (box.min[axis] - ray.origin[axis]) / ray.direction[axis];
        const double b = (box.max[axis] - ray.origin[axis]) / ray.direction[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
}

/// Pictures of what rays meet, opaque.
std::vector<Photograph> photographsOf(const std::vector<PhotoCamera>& cameras,
                                      const std::function<bool(const Ray&)>& meets) {
    std::vector<Photograph> photographs;
    for (const PhotoCamera& camera : cameras) {
        Photograph photograph{"view " + std::to_string(photographs.size()), camera,
                              Image(camera.width, camera.height, 4)};
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x)
                photograph.matte.at(x, y)[3] = meets(pixelRay(camera, x + 0.5, y + 0.5)) ? 1.0f : 0.0f;
        photographs.push_back(photograph);
    }
    return photographs;
}

}  // namespace

TEST(ObjectBounds, MiddleOfViewsIsWhereTheyLook) {
    for (auto projection : {Camera::Projection::Perspective, Camera::Projection::Orthographic}) {
        Poses poses = posesOf(camerasAround(kMiddle, 7, 5, projection));
        ASSERT_TRUE(middleOfViews(poses.views));
        // A few roundings of positions near 8, divided by a determinant of some tenths.
        EXPECT_LT((*middleOfViews(poses.views) - kMiddle).length(), 1e-13);
        poses.views.resize(1);
        poses.views.push_back(poses.views[0]);
        poses.views[1].camera.position += poses.views[1].camera.right;
        EXPECT_FALSE(middleOfViews(poses.views)) << "parallel";
    }
}

// Seen along the three axes, the place that all see is a box.
TEST(ObjectBounds, ThreeOrthographicViewsLeaveTheBoxThatTheySee) {
    std::vector<PhotoCamera> cameras;
    for (const auto& [direction, up, width, height] :
         {std::tuple(Vec3(1, 0, 0), Vec3(0, 0, 1), 30, 12), std::tuple(Vec3(0, 1, 0), Vec3(0, 0, 1), 20, 12),
          std::tuple(Vec3(0, 0, 1), Vec3(0, 1, 0), 20, 30)})
        cameras.push_back(photoCamera(orthographicFrom(direction, up, width, height)));
    const Box3 box = boundsSeenByAll(posesOf(cameras).views),
               expected(kMiddle - Vec3(1, 1.5, 0.6), kMiddle + Vec3(1, 1.5, 0.6));
    EXPECT_TRUE(contains(box, expected));
    // Cells of a 64th of a box that is at most a fourth larger: one around what is seen, and a part of one.
    EXPECT_LT(difference(box, expected), 2 * 1.25 * longest(expected) / 64);
}

TEST(ObjectBounds, HoldsAllThatEveryViewSeesAndLittleElse) {
    std::vector<PhotoCamera> cameras = camerasAround(kMiddle, 9, 5);
    cameras[3].distortion.k1 = 0.1;
    cameras[4].principalX += 7;
    const Box3 box = boundsSeenByAll(posesOf(cameras).views);
    Box3 seenByAll;
    for (const Vec3& point : somePoints(kMiddle, 3, 400000)) {
        const bool all = std::all_of(cameras.begin(), cameras.end(), [&](const PhotoCamera& camera) {
            const auto seen = project(camera, point);
            return seen && seen->x >= 0 && seen->x <= 80 && seen->y >= 0 && seen->y <= 60;
        });
        if (all) seenByAll.extendBy(point);
    }
    EXPECT_TRUE(contains(box, seenByAll));
    // A cell and a half of 4.8 / 64, and the distance of random points from the corners of what is seen: .126 found.
    EXPECT_LT(difference(box, seenByAll), 0.138);
    // One view that is far off changes nothing.
    cameras.push_back(cameras[0]);
    cameras.back().position += cameras.back().right * 30.0;
    EXPECT_LT(difference(boundsSeenByAll(posesOf(cameras).views), box), 1e-3);
}

TEST(ObjectBounds, CamerasThatSeeNothingTogetherAreNamed) {
    std::vector<PhotoCamera> cameras = camerasAround(kMiddle, 6, 5);
    for (PhotoCamera& camera : cameras) camera.forward = -camera.forward, camera.down = -camera.down;
    expectError<InvalidArgument>([&] { boundsSeenByAll(posesOf(cameras).views); }, "look at no common place");
    cameras.resize(1);
    expectError<InvalidArgument>([&] { boundsSeenByAll(posesOf(cameras).views); }, "all look one way; give bounds");
}

TEST(ObjectBounds, PointsCountWithoutBlundersAndSurroundings) {
    Poses poses = posesOf(camerasAround(kMiddle, 12, 5));
    poses.points = somePoints(kMiddle, 0.7, 4000);
    for (const Vec3& blunder : somePoints(kMiddle, 1000, 30, 2)) poses.points.push_back(blunder);
    for (const Vec3& far : somePoints(kMiddle + Vec3(40, 0, 0), 3, 3000, 3)) poses.points.push_back(far);
    const auto box = boundsOfPoints(poses);
    ASSERT_TRUE(box);
    // 1 % of 1.4 left out, a tenth of that added, on each side: 1.4 × (.1 × .98 − .01) = .123 more than the cube.
    // But for chance, and for blunders among them: .0027 found.
    EXPECT_LT(difference(*box, Box3(kMiddle - Vec3(0.823), kMiddle + Vec3(0.823))), 0.0029);
    EXPECT_EQ(estimatedBounds(poses).min, box->min);
    poses.bounds = Box3(Vec3(0), Vec3(1));
    EXPECT_EQ(estimatedBounds(poses).max, Vec3(1));
    poses.bounds.reset();
    poses.points.resize(19);
    EXPECT_FALSE(boundsOfPoints(poses));
    EXPECT_EQ(estimatedBounds(poses).min, boundsSeenByAll(poses.views).min);
}

// Seen along the axes a block is its own visual hull: no more is left than a cell around it, the part of one that it
// begins in, and a pixel of .01.
TEST(ObjectBounds, SilhouettesLeaveTheObjectAndACellAround) {
    const Box3 block(kMiddle - Vec3(0.7, 0.3, 0.2), kMiddle + Vec3(0.4, 0.6, 0.5)),
        wide(kMiddle - Vec3(9), kMiddle + Vec3(9));
    std::vector<PhotoCamera> cameras;
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
        Camera camera = orthographicFrom(direction, Vec3(direction.y, direction.z, direction.x), 200, 200);
        camera.orthoWidth = 2;
        cameras.push_back(photoCamera(camera));
    }
    const auto photographs = photographsOf(cameras, [&](const Ray& ray) { return meetsBox(ray, block); });
    for (const Box3& start : {boundsSeenByAll(posesOf(cameras).views), wide}) {
        const Box3 box = boundsOf(photographs, start);
        EXPECT_TRUE(contains(box, block));
        EXPECT_LT(difference(box, block), 2 * longest(box) / 64 + 0.01);
    }
    const Box3 inside(kMiddle - Vec3(0.3), kMiddle);
    EXPECT_TRUE(contains(inside, boundsOf(photographs, inside)));
}

// Of a ball views from around leave a little more than the ball.
TEST(ObjectBounds, SilhouettesOfManyViewsLeaveABallAndLittleElse) {
    const Vec3 center = kMiddle + Vec3(0.3, -0.2, 0.1);
    const Box3 ball(center - Vec3(0.5), center + Vec3(0.5));
    for (auto projection : {Camera::Projection::Perspective, Camera::Projection::Orthographic}) {
        std::vector<PhotoCamera> cameras = camerasAround(kMiddle, 30, 5, projection);
        for (PhotoCamera& camera : cameras) camera = resized(camera, 160, 120);
        const auto photographs = photographsOf(cameras, [&](const Ray& ray) { return meetsBall(ray, center, 0.5); });
        for (const Box3& start :
             {boundsSeenByAll(posesOf(cameras).views), Box3(kMiddle - Vec3(20), kMiddle + Vec3(20))}) {
            const Box3 box = boundsOf(photographs, start);
            EXPECT_TRUE(contains(box, ball));
            // Two cells of .016, up to a pixel of .03, and what the views do not cut away: .044 found.
            EXPECT_LT(difference(box, ball), 0.048);
        }
    }
}

// An object that some pictures cut off is still found whole.
TEST(ObjectBounds, PicturesThatCutTheObjectOffSayNothingAboutTheRest) {
    std::vector<PhotoCamera> cameras = camerasAround(kMiddle, 40, 5);
    for (PhotoCamera& camera : cameras) camera = resized(camera, 160, 120);
    for (std::size_t n = 0; n < cameras.size(); n += 3) cameras[n].focalX *= 5, cameras[n].focalY *= 5;
    const Box3 ball(kMiddle - Vec3(0.8), kMiddle + Vec3(0.8));
    const Box3 box = boundsOf(photographsOf(cameras, [&](const Ray& ray) { return meetsBall(ray, kMiddle, 0.8); }),
                              Box3(kMiddle - Vec3(2), kMiddle + Vec3(2)));
    EXPECT_TRUE(contains(box, ball));
    // Two cells of .025, and a part of a pixel: .0525 found.
    EXPECT_LT(difference(box, ball), 0.057);
}

TEST(ObjectBounds, ErrorsOfSilhouettesSayWhich) {
    const std::vector<PhotoCamera> cameras = camerasAround(kMiddle, 4, 5);
    const Box3 start(kMiddle - Vec3(1), kMiddle + Vec3(1));
    auto photographs = photographsOf(cameras, [&](const Ray& ray) { return meetsBall(ray, kMiddle, 0.3); });
    expectError<InvalidArgument>([&] { boundsOf({}, start); }, "no photographs");
    expectError<InvalidArgument>([&] { boundsOf(photographs, Box3()); }, "empty or not finite");
    expectError<InvalidArgument>([&] { boundsOf(photographs, Box3(Vec3(9), Vec3(10))); }, "no place within the bounds");
    std::fill(photographs[2].matte.pixels.begin(), photographs[2].matte.pixels.end(), 0.0f);
    expectError<InvalidArgument>([&] { boundsOf(photographs, start); }, "'view 2' shows nothing");
    photographs[1].camera.width = 81;
    expectError<InvalidArgument>([&] { boundsOf(photographs, start); }, "'view 1': its matte must be");
}

// Every ray that meets the lego meets its box; the box is much smaller than what the cameras see (.221 of it found).
TEST(ObjectBounds, OfTheLegoHoldAllItsSilhouettes) {
    const std::string path = findData("photos/lego");
    if (path.empty()) GTEST_SKIP() << "photos/lego is not on this machine; set RAYSWEEP_DATA";
    const Poses poses = readPoses(path);
    std::vector<Photograph> photographs;
    for (std::size_t n = 0; n < poses.views.size(); n += 2)
        photographs.push_back({poses.views[n].image, poses.views[n].camera, readImage(poses.views[n].image)});
    const Box3 start = estimatedBounds(poses), box = boundsOf(photographs, start);
    std::size_t missed = 0, covered = 0;
    for (const Photograph& photograph : photographs)
        for (int y = 0; y < photograph.matte.height; y += 3)
            for (int x = 0; x < photograph.matte.width; x += 3)
                if (photograph.matte.at(x, y)[3] > 0.5f) {
                    ++covered;
                    missed += !meetsBox(pixelRay(photograph.camera, x + 0.5, y + 0.5), box);
                }
    EXPECT_GT(covered, 10000u);
    EXPECT_EQ(missed, 0u);
    const Vec3 size = box.size(), before = start.size();
    EXPECT_LT(size.x * size.y * size.z, 0.24 * before.x * before.y * before.z);
}

// The photographs' backdrop is nearly black. The README gives the tight box of the temple. Beyond it are two cells of
// .0028, what 16 views from one ring do not cut away, and some of the foot it stands on: .0140 found.
TEST(ObjectBounds, OfTheTempleAreThoseOfItsReadme) {
    const std::string path = findData("photos/temple");
    if (path.empty()) GTEST_SKIP() << "photos/temple is not on this machine; set RAYSWEEP_DATA";
    const Box3 tight(Vec3(-0.073568, 0.021728, -0.012445), Vec3(0.028855, 0.181892, 0.062736));
    const Poses poses = readPoses(path);
    std::vector<Photograph> photographs;
    for (const Pose& pose : poses.views) {
        const Image image = readImage(pose.image);
        Photograph photograph{pose.image, pose.camera, Image(image.width, image.height, 4)};
        for (std::size_t p = 0; p < image.pixels.size() / 3; ++p)
            photograph.matte.pixels[4 * p + 3] =
                *std::max_element(&image.pixels[3 * p], &image.pixels[3 * p] + 3) > 0.05f ? 1.0f : 0.0f;
        photographs.push_back(photograph);
    }
    const Box3 box = boundsOf(photographs, estimatedBounds(poses));
    EXPECT_TRUE(contains(box, tight));
    EXPECT_LT(difference(box, tight), 0.0154);
}
