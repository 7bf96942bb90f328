// COLMAP's models, as text and as binary, against COLMAP's own definition of a pose: the camera sees X at q X q⁻¹ + t.
#include "raysweep/camera/poses.h"

#include "raysweep/core/error.h"
#include "support/expect_error.h"
#include "support/files.h"
#include "support/temporary_folder.h"
#include "unit/camera/pose_fixture.h"

#include <ImathQuat.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

using namespace raysweep;
using namespace raysweep::test;
namespace fs = std::filesystem;

namespace {

struct ModelCamera {
    std::uint32_t id;
    const char* model;
    std::int32_t number;
    std::uint64_t width, height;
    std::vector<double> parameters;
};

struct ModelImage {
    std::string name;
    Imath::Quatd rotation;
    Vec3 translation;
    std::uint32_t camera;
};

/// A model of one picture by each kind of camera, around the origin.
struct Model {
    std::vector<ModelCamera> cameras = {{7, "SIMPLE_PINHOLE", 0, 80, 60, {90, 41, 29}},
                                        {1, "PINHOLE", 1, 80, 60, {90, 95, 41, 29}},
                                        {3, "SIMPLE_RADIAL", 2, 80, 60, {90, 41, 29, 0.1}},
                                        {4, "RADIAL", 3, 80, 60, {90, 41, 29, 0.1, 0.02}},
                                        {5, "OPENCV", 4, 80, 60, {90, 95, 41, 29, 0.1, 0.02, 0.003, -0.004}}};
    std::vector<ModelImage> images;  // in the natural order of names
    std::vector<Vec3> points = somePoints(Vec3(0), 1, 4);

    Model() {
        const Vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0.3, 0.4, 1}, {-1, 2, 1}, {1, 1, -1}};
        for (std::size_t n = 0; n < cameras.size(); ++n) {
            Imath::Quatd rotation;
            rotation.setAxisAngle(axes[n].normalized(), 0.4 + 0.9 * double(n));
            // The last name has a space in it, and comes last only where 10 is more than 2.
            const std::string name = n == 4 ? "photo 10.exr" : "photo " + std::to_string(n) + ".exr";
            images.push_back({name, rotation.normalized(), Vec3(0.1, -0.2, 6 + double(n)), cameras[n].id});
        }
    }
};

void writeText(const std::string& folder, const Model& model) {
    std::ostringstream cameras, images, points;
    for (std::ostringstream* out : {&cameras, &images, &points}) {
        out->precision(17);
        *out << "# a comment\n";
    }
    for (const ModelCamera& c : model.cameras) {
        cameras << c.id << " " << c.model << " " << c.width << " " << c.height;
        for (const double p : c.parameters) cameras << " " << p;
        cameras << "\n";
    }
    for (auto image = model.images.rbegin(); image != model.images.rend(); ++image) {
        images << image - model.images.rbegin() + 3 << " " << image->rotation.r;
        for (int n = 0; n < 3; ++n) images << " " << image->rotation.v[n];
        for (int n = 0; n < 3; ++n) images << " " << image->translation[n];
        // What a picture shows of the points; nothing, in every other one.
        images << " " << image->camera << " " << image->name << "\n"
               << (image->camera % 2 ? "1 2 -1 3 4 17" : "") << "\n";
    }
    for (const Vec3& p : model.points) points << "3 " << p.x << " " << p.y << " " << p.z << " 9 9 9 0.5 1 2 3 4\n";
    writeBytes(folder + "/cameras.txt", cameras.str());
    writeBytes(folder + "/images.txt", images.str());
    writeBytes(folder + "/points3D.txt", points.str());
}

template <class Value>
void put(std::string& bytes, const Value& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string camerasInBinary(const Model& model) {
    std::string bytes;
    put(bytes, std::uint64_t(model.cameras.size()));
    for (const ModelCamera& c : model.cameras) {
        put(bytes, c.id);
        put(bytes, c.number);
        put(bytes, c.width);
        put(bytes, c.height);
        for (const double p : c.parameters) put(bytes, p);
    }
    return bytes;
}

std::string imagesInBinary(const Model& model) {
    std::string bytes;
    put(bytes, std::uint64_t(model.images.size()));
    for (auto image = model.images.rbegin(); image != model.images.rend(); ++image) {
        put(bytes, std::uint32_t(image - model.images.rbegin() + 3));
        put(bytes, image->rotation.r);
        for (int n = 0; n < 3; ++n) put(bytes, image->rotation.v[n]);
        for (int n = 0; n < 3; ++n) put(bytes, image->translation[n]);
        put(bytes, image->camera);
        bytes += image->name + '\0';
        const std::uint64_t points = image->camera % 2;
        put(bytes, points);
        bytes.append(24 * points, '\7');
    }
    return bytes;
}

std::string pointsInBinary(const Model& model) {
    std::string bytes;
    put(bytes, std::uint64_t(model.points.size()));
    for (const Vec3& p : model.points) {
        put(bytes, std::uint64_t(3));
        for (int n = 0; n < 3; ++n) put(bytes, p[n]);
        bytes += "rgb";
        put(bytes, 0.5);
        put(bytes, std::uint64_t(2));
        bytes.append(16, '\1');
    }
    return bytes;
}

void writeBinary(const std::string& folder, const Model& model) {
    writeBytes(folder + "/cameras.bin", camerasInBinary(model));
    writeBytes(folder + "/images.bin", imagesInBinary(model));
    writeBytes(folder + "/points3D.bin", pointsInBinary(model));
}

/// Where COLMAP's documentation says that the point is seen: models with fewer parameters are OPENCV's with zeros.
std::array<double, 2> seenBy(const ModelCamera& camera, const ModelImage& image, const Vec3& point) {
    std::vector<double> p = camera.parameters;
    if (camera.number != 1 && camera.number != 4) p.insert(p.begin(), p[0]);
    p.resize(8);
    const Vec3 c = image.rotation.rotateVector(point) + image.translation;
    const double x = c.x / c.z, y = c.y / c.z, r2 = x * x + y * y, radial = 1 + p[4] * r2 + p[5] * r2 * r2;
    return {p[0] * (x * radial + 2 * p[6] * x * y + p[7] * (r2 + 2 * x * x)) + p[2],
            p[1] * (y * radial + 2 * p[7] * x * y + p[6] * (r2 + 2 * y * y)) + p[3]};
}

void expectIs(const Poses& poses, const Model& model) {
    ASSERT_EQ(poses.views.size(), model.images.size());
    EXPECT_EQ(poses.axes, CameraAxes::openCv);
    EXPECT_EQ(poses.points, model.points);
    for (std::size_t n = 0; n < poses.views.size(); ++n) {
        EXPECT_EQ(fs::path(poses.views[n].image).filename(), model.images[n].name);
        EXPECT_EQ(poses.views[n].camera.width, 80);
        EXPECT_EQ(poses.views[n].camera.height, 60);
        for (const Vec3& point : somePoints(Vec3(0), 1, 20)) {
            const auto expected = seenBy(model.cameras[n], model.images[n], point);
            const auto seen = project(poses.views[n].camera, point);
            ASSERT_TRUE(seen);
            EXPECT_NEAR(seen->x, expected[0], 1e-12);  // a few roundings of numbers near 50
            EXPECT_NEAR(seen->y, expected[1], 1e-12);
        }
    }
}

class ColmapModel : public testing::Test {
  protected:
    void SetUp() override {
        for (const ModelImage& image : model.images) writePicture(folder / ("images/" + image.name), 80, 60);
    }
    void expectRefused(const std::string& part) {
        expectError<IoError>([&] { readPoses(folder / "sparse/0"); }, part);
    }
    TemporaryFolder folder;
    Model model;
};

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), by);
}

}  // namespace

TEST_F(ColmapModel, IsReadAsText) {
    writeText(folder / "sparse/0", model);
    expectIs(readPoses(folder / "sparse/0"), model);
    expectIs(readPoses(folder / "sparse/0/images.txt"), model);
    expectIs(readPoses(folder.path().string()), model);
    fs::remove(folder / "sparse/0/points3D.txt");
    EXPECT_TRUE(readPoses(folder / "sparse/0").points.empty());
}

TEST_F(ColmapModel, IsReadAsBinary) {
    writeBinary(folder / "sparse/0", model);
    expectIs(readPoses(folder / "sparse/0"), model);
    expectIs(readPoses(folder / "sparse/0/cameras.bin"), model);
    expectIs(readPoses(folder.path().string()), model);
}

TEST_F(ColmapModel, CanLieFarFromItsPictures) {
    writeBinary(folder / "model", model);
    fs::rename(folder / "images", folder / "photos");
    expectError<IoError>([&] { readPoses(folder / "model"); },
                         "images.bin', picture 'photo 0.exr': there is no picture 'photo 0.exr'");
    PoseOptions options;
    options.imageFolder = folder / "photos";
    expectIs(readPoses(folder / "model", options), model);
}

TEST_F(ColmapModel, AxesCanBeTakenAsTheOthers) {
    writeText(folder / "sparse/0", model);
    PoseOptions options;
    options.axes = CameraAxes::openGl;
    const Poses turned = readPoses(folder / "sparse/0", options), poses = readPoses(folder / "sparse/0");
    for (std::size_t n = 0; n < poses.views.size(); ++n) {
        EXPECT_EQ(turned.views[n].camera.position, poses.views[n].camera.position);
        EXPECT_EQ(turned.views[n].camera.forward, -poses.views[n].camera.forward);
    }
}

TEST_F(ColmapModel, ErrorsInTextNameTheLine) {
    writeText(folder / "sparse/0", model);
    const std::string cameras = folder / "sparse/0/cameras.txt", images = folder / "sparse/0/images.txt",
                      points = folder / "sparse/0/points3D.txt", good = contentsOf(cameras),
                      goodImages = contentsOf(images);
    writeBytes(cameras, replaced(good, "RADIAL 80", "FULL_OPENCV 80"));
    expectRefused("cameras.txt': line 4: the camera model SIMPLE_FULL_OPENCV is not known");
    writeBytes(cameras, replaced(good, "7 SIMPLE_PINHOLE", "7 FOV"));
    expectRefused("line 2: the camera model FOV is not known");
    writeBytes(cameras, replaced(good, "7 SIMPLE_PINHOLE", "7 PINHOLE"));
    expectRefused("line 2: the model PINHOLE has 4 parameters, but there are 3");
    writeBytes(cameras, replaced(good, "7 SIMPLE_PINHOLE", "1 SIMPLE_PINHOLE"));
    expectRefused("line 3: it is there twice");
    writeBytes(cameras, replaced(good, "80 60", "80 -60"));
    expectRefused("line 2: '-60' is not a whole number");
    writeBytes(cameras, replaced(good, "90 41", "x 41"));
    expectRefused("line 2: 'x' is not a number");
    writeBytes(cameras, replaced(good, "90 41", "0 41"));
    expectRefused("line 2: camera focalX 0");
    writeBytes(cameras, "# nothing\n");
    expectRefused("picture 'photo 0.exr': its camera 7 is not among the model's cameras");
    writeBytes(cameras, good);
    writeBytes(images, replaced(goodImages, "1 2 -1 3 4 17\n", ""));
    expectRefused("images.txt': line 3: the points of 'photo 10.exr' should be here");
    writeBytes(images, replaced(goodImages, "photo 0.exr", "photo 1.exr"));
    expectRefused("photo 1.exr' is there twice");
    writeBytes(images, "1 2 0 0 0 0 0 0 7 photo 0.exr\n\n");
    expectRefused("picture 'photo 0.exr': the quaternion of its rotation has the length 2");
    writeBytes(images, "1 1 0 0 0 0 0 0 7\n\n");
    expectRefused("line 1: it has 9 words");
    writeBytes(images, "");
    expectRefused("it has no pictures");
    writeBytes(images, goodImages);
    writeBytes(points, "1 2 3\n");
    expectRefused("points3D.txt': line 1: it has 3 words");
}

// Whatever is missing of a file, at its end or by its count, is found.
TEST_F(ColmapModel, DamagedBinaryFilesAreRefused) {
    const std::string sparse = folder / "sparse/0/";
    for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
        writeBinary(folder / "sparse/0", model);
        const std::string good = contentsOf(sparse + name);
        for (std::size_t size = 0; size < good.size(); size += 3) {
            writeBytes(sparse + name, good.substr(0, size));
            expectRefused("the file ends early, at byte " + std::to_string(size));
        }
        expectRefused(std::string(name) + "': ");
        writeBytes(sparse + name, good + "x");
        expectRefused("1 bytes are left over");
        writeBytes(sparse + name, std::string(1, char(good[0] + 1)) + good.substr(1));
        expectRefused("ends early");
    }
    writeBinary(folder / "sparse/0", model);
    const std::string good = contentsOf(sparse + "cameras.bin");
    for (const auto& [number, name] :
         {std::pair(5, "OPENCV_FISHEYE"), std::pair(10, "THIN_PRISM_FISHEYE"), std::pair(99, "of number 99")}) {
        std::string other = good;
        other[12] = char(number);
        writeBytes(sparse + "cameras.bin", other);
        expectRefused("camera 1 of 5: the camera model " + std::string(name) + " is not known");
    }
}
