// Poses from transforms.json, lists of matrices, and what is done to them; COLMAP's are in colmap_test.cpp.
#include "raysweep/camera/poses.h"

#include "raysweep/core/error.h"
#include "support/expect_error.h"
#include "support/files.h"
#include "support/temporary_folder.h"
#include "support/volumes.h"
#include "unit/camera/pose_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>

using namespace raysweep;
using namespace raysweep::test;
namespace fs = std::filesystem;

namespace {

/// From (0, 0, 5) along -z onto the origin, y up.
constexpr const char* kFromAbove = R"("transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]])";

std::string frame(const std::string& fields) {
    return "{" + fields + ", " + kFromAbove + "}";
}

std::string transforms(const std::string& fields, const std::string& frames) {
    return "{" + fields + (fields.empty() ? "" : ", ") + "\"frames\": [" + frames + "]}";
}

/// A folder with the pictures a.exr and b.exr of 40x30.
class PoseFile : public testing::Test {
  protected:
    void SetUp() override {
        writePicture(folder / "a.exr", 40, 30);
        writePicture(folder / "b.exr", 40, 30);
    }
    Poses read(const std::string& text, const PoseOptions& options = {}, const char* name = "transforms.json") {
        writeBytes(folder / name, text);
        return readPoses(folder / name, options);
    }
    void expectRefused(const std::string& text, const std::string& part, const char* name = "transforms.json") {
        expectError<IoError>([&] { read(text, {}, name); }, part);
        expectError<IoError>([&] { read(text, {}, name); }, name);
    }
    TemporaryFolder folder;
};

void expectSame(const PhotoCamera& a, const PhotoCamera& b) {
    EXPECT_EQ(a.projection, b.projection);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.right, b.right);
    EXPECT_EQ(a.down, b.down);
    EXPECT_EQ(a.forward, b.forward);
    EXPECT_EQ(a.focalX, b.focalX);
    EXPECT_EQ(a.focalY, b.focalY);
    EXPECT_EQ(a.principalX, b.principalX);
    EXPECT_EQ(a.principalY, b.principalY);
    EXPECT_EQ(a.distortion.k1, b.distortion.k1);
    EXPECT_EQ(a.distortion.k2, b.distortion.k2);
    EXPECT_EQ(a.distortion.p1, b.distortion.p1);
    EXPECT_EQ(a.distortion.p2, b.distortion.p2);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
}

void expectSame(const Poses& a, const Poses& b) {
    ASSERT_EQ(a.views.size(), b.views.size());
    for (std::size_t n = 0; n < a.views.size(); ++n) {
        EXPECT_EQ(a.views[n].image, b.views[n].image);
        EXPECT_EQ(a.views[n].mask, b.views[n].mask);
        EXPECT_EQ(a.views[n].onWhite, b.views[n].onWhite);
        EXPECT_EQ(a.views[n].onBlack, b.views[n].onBlack);
        expectSame(a.views[n].camera, b.views[n].camera);
    }
    EXPECT_EQ(a.points, b.points);
    ASSERT_EQ(a.bounds.has_value(), b.bounds.has_value());
    if (a.bounds) {
        EXPECT_EQ(a.bounds->min, b.bounds->min);
        EXPECT_EQ(a.bounds->max, b.bounds->max);
    }
}

}  // namespace

TEST_F(PoseFile, NeRFsNeedsNothingButAnAngleAndPictures) {
    writePicture(folder / "train/r_0.png", 40, 30);
    writePicture(folder / "train/r_1.5.png", 40, 30);
    const Poses poses = read(transforms("\"camera_angle_x\": 0.8", frame("\"file_path\": \"./train/r_0\"") + "," +
                                                                       frame("\"file_path\": \"train/r_1.5\"")));
    ASSERT_EQ(poses.views.size(), 2u);
    EXPECT_EQ(poses.axes, CameraAxes::openGl);
    EXPECT_EQ(poses.views[0].image, folder / "train/r_0.png");
    EXPECT_EQ(poses.views[1].image, folder / "train/r_1.5.png");
    const PhotoCamera& camera = poses.views[0].camera;
    EXPECT_EQ(camera.width, 40);
    EXPECT_EQ(camera.height, 30);
    EXPECT_EQ(camera.position, Vec3(0, 0, 5));
    EXPECT_EQ(pixelRay(camera, 20, 15).direction, Vec3(0, 0, -1));
    const Ray right = pixelRay(camera, 40, 15), top = pixelRay(camera, 20, 0);
    // Half of the angle to the right; pixels are square, so 3/4 of the tangent upwards. A few roundings.
    EXPECT_NEAR(right.direction.x / -right.direction.z, std::tan(0.4), 1e-14);
    EXPECT_NEAR(top.direction.y / -top.direction.z, 0.75 * std::tan(0.4), 1e-14);
}

TEST_F(PoseFile, NerfstudiosIntrinsicsHoldForTheFileOrAFrame) {
    writePicture(folder / "masks/a.exr", 40, 30);
    const std::string file = R"("camera_model": "OPENCV", "w": 400.0, "h": 300, "fl_x": 500, "fl_y": 510, "cx": 190,
        "cy": 160, "k1": 0.1, "k2": 0.01, "p1": 0.001, "p2": 0.002, "k3": 0, "is_fisheye": false, "orientation": "up",
        "aabb": [[-1,-2,-3],[1,2,3]])";
    const Poses poses = read(transforms(
        file, frame("\"file_path\": \"a.exr\", \"mask_path\": \"masks/a.exr\"") + "," +
                  frame("\"file_path\": \"b.exr\", \"w\": 200, \"h\": 150, \"fl_x\": 250, \"k1\": 0.3, \"cx\": 95")));
    const PhotoCamera &a = poses.views[0].camera, &b = poses.views[1].camera;
    EXPECT_EQ(poses.views[0].mask, folder / "masks/a.exr");
    EXPECT_EQ(poses.views[1].mask, "");
    EXPECT_EQ(a.width, 400);
    EXPECT_EQ(a.focalX, 500);
    EXPECT_EQ(a.focalY, 510);
    EXPECT_EQ(a.principalX, 190);
    EXPECT_EQ(a.principalY, 160);
    EXPECT_EQ(a.distortion.k1, 0.1);
    EXPECT_EQ(a.distortion.k2, 0.01);
    EXPECT_EQ(a.distortion.p1, 0.001);
    EXPECT_EQ(a.distortion.p2, 0.002);
    EXPECT_EQ(b.width, 200);
    EXPECT_EQ(b.focalX, 250);
    EXPECT_EQ(b.focalY, 510);
    EXPECT_EQ(b.principalX, 95);
    EXPECT_EQ(b.distortion.k1, 0.3);
    ASSERT_TRUE(poses.bounds);
    EXPECT_EQ(poses.bounds->max, Vec3(1, 2, 3));
}

TEST_F(PoseFile, AxesCanBeTakenAsTheOthers) {
    const std::string text = transforms("\"fl_x\": 50", frame("\"file_path\": \"a\""));
    PoseOptions options;
    options.axes = CameraAxes::openCv;
    const Poses asOpenCv = read(text, options), asOpenGl = read(text);
    EXPECT_EQ(asOpenCv.views[0].camera.forward, Vec3(0, 0, 1));
    EXPECT_EQ(asOpenCv.views[0].camera.down, Vec3(0, 1, 0));
    expectSame(withConvention(asOpenGl, CameraAxes::openCv), asOpenCv);
    expectSame(withConvention(asOpenCv, CameraAxes::openGl), asOpenGl);
    expectSame(withConvention(asOpenGl, CameraAxes::openGl), asOpenGl);
}

TEST_F(PoseFile, OrthographicCamerasHaveAScaleInsteadOfAFocalLength) {
    const Poses poses =
        read(transforms("\"camera_model\": \"ORTHOGRAPHIC\", \"fl_x\": 10", frame("\"file_path\": \"a.exr\"")));
    const Ray corner = pixelRay(poses.views[0].camera, 40, 0);  // 20 pixels to the right, 15 up
    EXPECT_LT((corner.origin - Vec3(2, 1.5, 5)).length(), 1e-14);
    EXPECT_EQ(corner.direction, Vec3(0, 0, -1));
}

TEST_F(PoseFile, PicturesCanBeElsewhere) {
    writePicture(folder / "other/c.exr", 20, 10);
    PoseOptions options;
    options.imageFolder = folder / "other";
    const Poses poses = read(transforms("\"fl_x\": 50", frame("\"file_path\": \"images/c.exr\"")), options);
    EXPECT_EQ(poses.views[0].image, folder / "other/c.exr");
    EXPECT_EQ(poses.views[0].camera.width, 20);
}

TEST_F(PoseFile, WrittenOnesAreReadBackBitByBit) {
    for (const char* name : {"view0.exr", "view1.exr", "view2.exr", "m.exr", "w.exr", "k.exr"})
        writePicture(folder / (std::string("views/") + name), 4, 3);
    Poses poses = posesOf(camerasAround(Vec3(0.1, 0.2, 0.3), 3, 4));
    for (Pose& pose : poses.views) pose.image = folder / ("views/" + pose.image);
    poses.views[1].mask = folder / "views/m.exr";
    poses.views[1].onWhite = folder / "views/w.exr";
    poses.views[1].onBlack = folder / "views/k.exr";
    writeTransforms(folder / "transforms.json", poses);
    expectSame(readPoses(folder / "transforms.json"), poses);
    expectSame(readPoses(folder.path().string()), poses);
    // All that can differ, differs.
    poses.views[0].camera.distortion = {0.1 / 3, -0.1, 1e-3 / 7, 1e-5};
    poses.views[1].camera.projection = Camera::Projection::Orthographic;
    poses.views[1].camera.focalY *= 1.1;
    poses.views[2].camera.principalX += 1.0 / 3;
    poses.bounds = Box3(Vec3(-1.0 / 3, 0, 0.1), Vec3(0.2, 1e-300, 1e10));
    poses.points = somePoints(Vec3(0), 1, 5);
    writeTransforms(folder / "transforms.json", poses);
    expectSame(readPoses(folder / "transforms.json"), poses);
    poses.views[0].camera.focalX = 0;
    expectError<InvalidArgument>([&] { writeTransforms(folder / "t.json", poses); }, "view0.exr': camera focalX");
    expectError<InvalidArgument>([&] { writeTransforms(folder / "t.json", Poses()); }, "no poses");
    EXPECT_FALSE(fs::exists(folder / "t.json"));
}

// What floats leave of a rotation is made one again, the nearest.
TEST_F(PoseFile, RotationsThatAreNearlyOnesAreMadeSo) {
    const std::string matrix = R"("transform_matrix": [[1,0.0002,0,0],[0.0002,1.0003,0,0],[0,0,1,5],[0,0,0,1]])";
    const Poses poses = read(transforms("\"fl_x\": 50", "{\"file_path\": \"a.exr\", " + matrix + "}"));
    const PhotoCamera& camera = poses.views[0].camera;
    // The matrix is symmetric, so the nearest rotation is none at all; a few roundings.
    EXPECT_LT((camera.right - Vec3(1, 0, 0)).length(), 1e-14);
    EXPECT_LT((camera.down - Vec3(0, -1, 0)).length(), 1e-14);
}

TEST_F(PoseFile, ErrorsSayWhereAndWhatToDo) {
    const std::string good = "\"file_path\": \"a.exr\"", lens = "\"fl_x\": 50";
    expectRefused("", "nothing in it");
    expectRefused("{\"frames\": [", "not valid JSON");
    expectRefused("{}", "'frames' is missing");
    expectRefused(transforms(lens, ""), "'frames' must be an array of at least one");
    expectRefused(transforms("", frame(good)), "frames[0] ('a.exr'): it has neither 'fl_x' nor 'camera_angle_x'");
    expectRefused(transforms("\"fl_x\": \"wide\"", frame(good)), "'fl_x' must be a number");
    expectRefused(transforms("\"fl_x\": -3", frame(good)), "frames[0] ('a.exr'): camera focalX -3: must be positive");
    expectRefused(transforms("\"camera_angle_x\": 40", frame(good)), "'camera_angle_x' must be an angle");
    expectRefused(transforms(lens + ", \"w\": 40.5", frame(good)), "'w' must be a whole number of pixels");
    expectRefused(transforms(lens, frame("\"file_path\": \"none\"")), "frames[0] ('none'): there is no picture 'none'");
    expectRefused(transforms(lens, frame(good + ", \"mask_path\": \"m\"")), "there is no picture 'm'");
    expectRefused(transforms(lens, frame(good) + "," + frame(good)), "a.exr' is there twice, as views 0 and 1");
    expectRefused(transforms(lens + ", \"camera_model\": \"OPENCV_FISHEYE\"", frame(good)), "OPENCV_FISHEYE");
    expectRefused(transforms(lens + ", \"is_fisheye\": true", frame(good)), "is_fisheye");
    expectRefused(transforms(lens + ", \"k3\": 0.1", frame(good)), "'k3' is not 0");
    expectRefused(transforms(lens + ", \"bounds\": [[0,0,0],[1,0,1]]", frame(good)), "'bounds' must be a box");
    expectRefused(transforms("\"camera_model\": \"ORTHOGRAPHIC\", \"camera_angle_x\": 1", frame(good)), "needs 'fl_x'");
    expectRefused(transforms("\"camera_model\": \"ORTHOGRAPHIC\", \"k1\": 1, \"fl_x\": 1", frame(good)), "no lens");
    const auto withMatrix = [&](const std::string& rows) {
        return transforms(lens, frame(good) + ",{\"file_path\": \"b.exr\", \"transform_matrix\": " + rows + "}");
    };
    expectRefused(withMatrix("[[1,0,0,0],[0,1,0,0]]"), "frames[1].transform_matrix' must be four rows of four");
    expectRefused(withMatrix("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]]"), "whose last row is 0, 0, 0, 1");
    expectRefused(withMatrix("[[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]"),
                  "frames[1] ('b.exr'): its rotation is none: the axes have the lengths 2, 2, 2");
    expectRefused(withMatrix("[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]"), "mirrors");
    expectError<IoError>([&] { readPoses(folder / "none.json"); }, "none.json': there is no such file");
    fs::create_directory(folder / "empty");
    expectError<IoError>([&] { readPoses(folder / "empty"); }, "there are no poses in this folder");
    PoseOptions options;
    options.imageFolder = folder / "nowhere";
    expectError<IoError>([&] { read(transforms(lens, frame(good)), options); }, "nowhere', does not exist");
    expectRefused("some words that are no poses\n", "not recognised", "list.txt");
}

namespace {

/// The same cameras as matrices: pixels count from the middle of the first.
struct Matrices {
    std::string middlebury, projections;
};

Matrices matricesOf(const Poses& poses) {
    std::ostringstream middlebury, projections;
    middlebury.precision(17);
    projections.precision(17);
    middlebury << poses.views.size() << "\n";
    double scale = -3;
    for (const Pose& pose : poses.views) {
        const PhotoCamera& c = pose.camera;
        const double fx = c.focalX, fy = c.focalY, cx = c.principalX - 0.5, cy = c.principalY - 0.5;
        middlebury << pose.image << " " << fx << " 0 " << cx << " 0 " << fy << " " << cy << " 0 0 1";
        projections << pose.image;
        for (const Vec3& axis : {c.right, c.down, c.forward})
            middlebury << " " << axis.x << " " << axis.y << " " << axis.z;
        for (const Vec3& axis : {c.right, c.down, c.forward}) middlebury << " " << -axis.dot(c.position);
        for (const Vec3& row : {c.right * fx + c.forward * cx, c.down * fy + c.forward * cy, c.forward})
            projections << " " << scale * row.x << " " << scale * row.y << " " << scale * row.z << " "
                        << -scale * row.dot(c.position);
        middlebury << "\n";
        projections << "\n";
        scale = 0.5 - scale;  // of either sign
    }
    return {middlebury.str(), projections.str()};
}

void expectSeeTheSame(const Poses& a, const Poses& b, double pixels) {
    ASSERT_EQ(a.views.size(), b.views.size());
    for (std::size_t n = 0; n < a.views.size(); ++n)
        for (const Vec3& point : somePoints(Vec3(0), 1, 20)) {
            const auto seenA = project(a.views[n].camera, point), seenB = project(b.views[n].camera, point);
            ASSERT_TRUE(seenA && seenB);
            EXPECT_NEAR(seenA->x, seenB->x, pixels);
            EXPECT_NEAR(seenA->y, seenB->y, pixels);
            EXPECT_NEAR(seenA->depth, seenB->depth, pixels);
        }
}

}  // namespace

TEST_F(PoseFile, MatricesAreTakenApart) {
    Poses poses = posesOf(camerasAround(Vec3(0.1, -0.2, 0.3), 5, 6));
    for (Pose& pose : poses.views) {
        writePicture(folder / pose.image, 80, 60);
        pose.camera.focalY *= 1.02;
        pose.camera.principalX += 3;
    }
    const Matrices matrices = matricesOf(poses);
    // 17 digits, and a few roundings of numbers of some hundred.
    expectSeeTheSame(read(matrices.middlebury, {}, "some_par.txt"), poses, 1e-11);
    expectSeeTheSame(readPoses(folder.path().string()), poses, 1e-11);
    expectSeeTheSame(read("# name P\n" + matrices.projections, {}, "matrices.txt"), poses, 1e-11);
    expectRefused("6" + matrices.middlebury.substr(1), "says 6 pictures, but there are 5", "some_par.txt");
    expectRefused(matrices.projections + "view9.exr 1 2 3\n", "line 6 ('view9.exr'): there are 4 words", "m.txt");
    expectRefused(matrices.projections + "b.exr 1 0 0 0 0 1 0 0 0 0 0 1\n", "no perspective camera's", "m.txt");
    expectRefused(matrices.projections + "b.exr 1 0 0 0 0 1 0 0 0 0 one 1\n", "'one' is not a number", "m.txt");
    expectRefused(matrices.projections + "b.exr 90 9 0 0 0 90 0 0 0 0 1 1\n", "skewed", "m.txt");
    expectRefused("1\na.exr 9 0 9 0 9 9 0 0 1 1 0 0 0 1 0 0 0 2 0 0 0\n", "line 2 ('a.exr'): its rotation is none",
                  "some_par.txt");
    expectRefused("1\na.exr 9 0 9 1 9 9 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n", "K must be an upper triangle", "p_par.txt");
    expectRefused("0\n", "it has no pictures", "p_par.txt");
}

TEST(Poses, PicturesMadeSmallerKeepTheirCameras) {
    const PhotoCamera camera = camerasAround(Vec3(0), 1, 4)[0];  // of 80x60
    EXPECT_EQ(matchedTo(camera, 80, 60, "p").focalX, camera.focalX);
    EXPECT_EQ(matchedTo(camera, 40, 30, "p").focalX, camera.focalX / 2);
    EXPECT_EQ(matchedTo(camera, 120, 90, "p").principalY, 45);
    expectError<InvalidArgument>([&] { matchedTo(camera, 80, 59, "p.png"); }, "'p.png' has 80x59 pixels");
    expectError<InvalidArgument>([&] { matchedTo(camera, 60, 80, "p.png"); }, "80x60");
}

TEST(Poses, OfTheLegoLookAtItsMiddle) {
    const std::string path = findData("photos/lego/transforms_train.json");
    if (path.empty()) GTEST_SKIP() << "photos/lego is not on this machine; set RAYSWEEP_DATA";
    const Poses poses = readPoses(path);
    EXPECT_EQ(poses.views.size(), 25u);
    for (const Pose& pose : poses.views) {
        EXPECT_EQ(pose.camera.width, 800);
        const Vec3 aside = pose.camera.position.cross(pose.camera.forward);
        // The scene was made with its middle in the origin; its numbers are floats near 4: 2.5e-6 found.
        EXPECT_LT(aside.length(), 2.7e-6);
        EXPECT_LT(pose.camera.position.dot(pose.camera.forward), 0);
    }
}

TEST(Poses, OfTheTempleSeeItsBox) {
    const std::string folder = findData("photos/temple");
    if (folder.empty()) GTEST_SKIP() << "photos/temple is not on this machine; set RAYSWEEP_DATA";
    const Poses poses = readPoses(folder);
    const Box3 box(Vec3(-0.073568, 0.021728, -0.012445), Vec3(0.028855, 0.181892, 0.062736));  // its README's
    EXPECT_EQ(poses.views.size(), 16u);
    for (const Pose& pose : poses.views)
        for (int corner = 0; corner < 8; ++corner) {
            const auto seen =
                project(pose.camera, Vec3(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                                          corner & 4 ? box.max.z : box.min.z));
            ASSERT_TRUE(seen);
            EXPECT_TRUE(seen->x > 0 && seen->x < 640 && seen->y > 0 && seen->y < 480) << seen->x << " " << seen->y;
        }
}
