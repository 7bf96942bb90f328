#include "raysweep/camera/photograph_files.h"
#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/matte_picture.h"
#include "support/temporary_folder.h"
#include "support/volumes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

using namespace raysweep;
using Matting = MattingOptions::Matting;
using Kind = PhotographWarning::Kind;

namespace {

PhotoCamera cameraOf(int width, int height) {
    PhotoCamera camera;
    camera.focalX = camera.focalY = 50;
    camera.principalX = 0.5 * width + 1;
    camera.principalY = 0.5 * height - 1;
    camera.width = width;
    camera.height = height;
    return camera;
}

/// A coloured square of 8 x 6 pixels in the middle of 20 x 16; RGBA. The alphas of its columns go from 1/8 to 1.
Image object(float brightness = 0.5f) {
    Image image(20, 16, 4);
    for (int y = 5; y < 11; ++y)
        for (int x = 6; x < 14; ++x) {
            const float alpha = float(x - 5) / 8;
            float* const to = image.at(x, y);
            to[0] = alpha * brightness, to[1] = alpha * 0.25f * float(x % 3), to[2] = alpha * 0.1f * float(y % 4);
            to[3] = alpha;
        }
    return image;
}

Image before(const Image& object, float backdrop) {
    Image picture(object.width, object.height, 3);
    for (std::size_t p = 0; p < object.pixels.size() / 4; ++p)
        for (std::size_t c = 0; c < 3; ++c)
            picture.pixels[3 * p + c] = object.pixels[4 * p + c] + (1 - object.pixels[4 * p + 3]) * backdrop;
    return picture;
}

class PhotographFiles : public testing::Test {
  protected:
    std::string write(const std::string& name, const Image& image) const {
        const std::string path = folder_ / name;
        std::filesystem::create_directories(std::filesystem::path(path).parent_path());
        writeImage(path, image);
        return path;
    }
    /// Views of the object, in EXR files with alpha.
    Poses views(int count) const {
        Poses poses;
        for (int n = 0; n < count; ++n) {
            Pose pose;
            pose.image = write("view" + std::to_string(n) + ".exr", object(0.1f * float(n + 1)));
            pose.camera = cameraOf(20, 16);
            poses.views.push_back(pose);
        }
        return poses;
    }
    Pose pair(const std::string& name, const Image& of) const {
        Pose pose;
        pose.onWhite = write(name + "_white.exr", before(of, 1));
        pose.onBlack = write(name + "_black.exr", before(of, 0));
        pose.camera = cameraOf(20, 16);
        return pose;
    }
    test::TemporaryFolder folder_;
};

template <class Expected>
std::string messageOf(const std::function<void()>& call) {
    try {
        call();
    } catch (const Expected& e) {
        return e.what();
    }
    return "";
}

bool names(const std::string& message, const std::string& word) {
    return message.find(word) != std::string::npos;
}

PhotographOptions by(Matting matting) {
    PhotographOptions options;
    options.matting.matting = matting;
    return options;
}

bool warns(const Photographs& photographs, Kind kind, const std::string& word) {
    return std::any_of(photographs.warnings.begin(), photographs.warnings.end(),
                       [&](const PhotographWarning& w) { return w.kind == kind && names(w.message, word); });
}

}  // namespace

TEST_F(PhotographFiles, AreReadInTheOrderOfThePoses) {
    const Poses poses = views(7);
    std::vector<double> fractions;
    const Photographs photographs = readPhotographs(poses, {}, [&](const std::string&, double fraction) {
        fractions.push_back(fraction);
        return true;
    });
    ASSERT_EQ(photographs.views.size(), 7u);
    ASSERT_EQ(photographs.reports.size(), 7u);
    EXPECT_TRUE(photographs.complete);
    EXPECT_TRUE(photographs.warnings.empty());
    for (int n = 0; n < 7; ++n) {
        const Photograph& view = photographs.views[std::size_t(n)];
        EXPECT_EQ(view.name, poses.views[std::size_t(n)].image);
        EXPECT_EQ(view.matte.pixels, object(0.1f * float(n + 1)).pixels);
        EXPECT_EQ(view.camera.width, 20);
        EXPECT_EQ(view.camera.principalX, 11);
        EXPECT_EQ(photographs.reports[std::size_t(n)].covered, 48u);
    }
    EXPECT_FALSE(fractions.empty());
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
}

TEST_F(PhotographFiles, PairsGiveBackTheObject) {
    Poses poses;
    poses.views = {pair("a", object()), pair("b", object(0.9f))};
    const Photographs photographs = readPhotographs(poses, by(Matting::whiteBlack));
    for (std::size_t i = 0; i < 20 * 16 * 4; ++i)  // floats up to 1, rounded twice
        EXPECT_NEAR(photographs.views[1].matte.pixels[i], object(0.9f).pixels[i], 1.3e-7) << i;
    EXPECT_EQ(photographs.views[0].name, poses.views[0].onWhite);
    EXPECT_TRUE(photographs.warnings.empty());
    poses.views[1].onBlack.clear();
    const std::string message = messageOf<InvalidArgument>([&] { readPhotographs(poses, by(Matting::whiteBlack)); });
    EXPECT_TRUE(names(message, "b_white.exr") && names(message, "before a black backdrop")) << message;
}

TEST_F(PhotographFiles, OneOfThePairServesForItsBackdrop) {
    Poses poses;
    poses.views = {pair("a", object()), pair("b", object())};
    EXPECT_EQ(readPhotographs(poses, by(Matting::black)).views[0].name, poses.views[0].onBlack);
    EXPECT_EQ(readPhotographs(poses, by(Matting::white)).views[0].name, poses.views[0].onWhite);
    const std::string message = messageOf<InvalidArgument>([&] { readPhotographs(poses, by(Matting::alpha)); });
    EXPECT_TRUE(names(message, "a_white.exr")) << message;
}

// A camera of half the size is made that of the picture; a picture of another shape is not the camera's.
TEST_F(PhotographFiles, SizesMustFit) {
    Poses poses = views(2);
    poses.views[0].camera = cameraOf(10, 8);
    const Photographs photographs = readPhotographs(poses);
    EXPECT_EQ(photographs.views[0].camera.width, 20);
    EXPECT_EQ(photographs.views[0].camera.focalX, 100);
    poses.views[1].camera = cameraOf(20, 15);
    const std::string message = messageOf<InvalidArgument>([&] { readPhotographs(poses); });
    EXPECT_TRUE(names(message, "20x16") && names(message, "20x15") && names(message, "view1.exr")) << message;
}

// The light of squares is averaged, and a point of the world stays where it was: 16 rows are 5 squares of 3 and one row
// that is left out, 20 columns 6 and two.
TEST_F(PhotographFiles, ReductionTakesPictureAndCameraAlong) {
    PhotographOptions options;
    options.reduction = 3;
    const Poses poses = views(2);
    const Photographs photographs = readPhotographs(poses, options);
    const Photograph& view = photographs.views[1];
    EXPECT_EQ(view.matte.pixels, reduced(object(0.2f), 3).pixels);
    EXPECT_EQ(view.camera.width, 6);
    EXPECT_EQ(view.camera.height, 5);
    EXPECT_EQ(photographs.reports[1].pixels, 320u) << "reports are of the pictures as they were";
    const Vec3 point(0.3, 5, -0.2);
    const auto whole = project(poses.views[1].camera, point), small = project(view.camera, point);
    ASSERT_TRUE(whole && small);
    EXPECT_NEAR(small->x, whole->x / 3, 1e-12);  // doubles up to 20
    EXPECT_NEAR(small->y, whole->y / 3, 1e-12);
}

TEST_F(PhotographFiles, MasksAreFoundByTheirPicturesNames) {
    Poses poses = views(3);
    PhotographOptions options = by(Matting::masks);
    EXPECT_TRUE(names(messageOf<InvalidArgument>([&] { readPhotographs(poses, options); }), "view0.exr"));
    Image mask(10, 8, 1);
    *mask.at(5, 4) = 1;
    poses.views[0].mask = poses.views[1].mask = poses.views[2].mask = write("some.exr", mask);
    EXPECT_EQ(readPhotographs(poses, options).reports[2].covered, 4u);
    options.maskFolder = folder_ / "masks";
    write("masks/view0.exr", mask);
    write("masks/view1.exr.png", mask);
    EXPECT_TRUE(names(messageOf<IoError>([&] { readPhotographs(poses, options); }), "view2"));
    write("masks/view2.png", mask);
    EXPECT_EQ(readPhotographs(poses, options).reports[2].covered, 4u);
    write("masks/view1.exr.png", Image(9, 9, 1));
    const std::string message = messageOf<InvalidArgument>([&] { readPhotographs(poses, options); });
    EXPECT_TRUE(names(message, "view1.exr") && names(message, "9x9") && names(message, "20x16")) << message;
}

TEST_F(PhotographFiles, EmptyViewsAreToldAndNothingAtAllIsRefused) {
    Poses poses = views(4);
    poses.views[2].image = write("nothing.exr", Image(20, 16, 4));
    const Photographs photographs = readPhotographs(poses);
    ASSERT_EQ(photographs.warnings.size(), 1u);
    EXPECT_TRUE(warns(photographs, Kind::emptyViews, "1 of 4"));
    EXPECT_TRUE(warns(photographs, Kind::emptyViews, "nothing.exr"));
    for (Pose& pose : poses.views) pose.image = poses.views[2].image;
    EXPECT_TRUE(names(messageOf<InvalidArgument>([&] { readPhotographs(poses); }), "no view shows the object"));
    poses.views.clear();
    EXPECT_TRUE(names(messageOf<InvalidArgument>([&] { readPhotographs(poses); }), "no views"));
}

TEST_F(PhotographFiles, DoubtfulViewsAreTold) {
    EXPECT_TRUE(warns(readPhotographs(views(1)), Kind::oneView, "one view"));
    Poses poses = views(2);
    Image full(20, 16, 4);
    std::fill(full.pixels.begin(), full.pixels.end(), 1.0f);
    poses.views[1].image = write("full.exr", full);
    EXPECT_TRUE(warns(readPhotographs(poses), Kind::fullViews, "full.exr"));
    Image odd = object();
    odd.at(0, 0)[0] = 1;  // light of nothing: 1 of 48 pixels
    poses.views[1].image = write("odd.exr", odd);
    EXPECT_TRUE(warns(readPhotographs(poses), Kind::inconsistent, "odd.exr"));
}

TEST_F(PhotographFiles, PairsThatDoNotLieOnEachOtherAreTold) {
    const Image still = object();
    Image moved(20, 16, 4);
    for (int y = 1; y < 16; ++y)
        for (int x = 0; x < 18; ++x) std::copy_n(still.at(x, y), 4, moved.at(x + 2, y - 1));
    Poses poses;
    poses.views = {pair("a", still), pair("b", still)};
    poses.views[1].onBlack = write("moved.exr", before(moved, 0));
    const Photographs photographs = readPhotographs(poses, by(Matting::whiteBlack));
    ASSERT_TRUE(photographs.reports[1].misregistration);
    EXPECT_EQ(photographs.reports[1].misregistration->x, 2);
    EXPECT_EQ(photographs.reports[1].misregistration->y, -1);
    EXPECT_TRUE(warns(photographs, Kind::misregistration, "1 of 2"));
    EXPECT_TRUE(warns(photographs, Kind::misregistration, "by up to 2 pixels"));
}

TEST_F(PhotographFiles, MattesAreShownUnderTheirPicturesNames) {
    Poses poses = views(2);
    Pose again = poses.views[0];
    again.image = write("other/view0.exr", object(0.7f));
    poses.views.push_back(again);
    PhotographOptions options;
    options.matteFolder = folder_ / "mattes";
    options.reduction = 2;
    readPhotographs(poses, options);
    for (const char* name : {"view0.png", "view1.png", "view0-2.png"}) {
        const Image shown = readImage((std::filesystem::path(options.matteFolder) / name).string());
        EXPECT_EQ(shown.width, 40) << name;
        EXPECT_EQ(shown.height, 16) << name;
    }
}

TEST_F(PhotographFiles, OfSeveralErrorsTheFirstIsTold) {
    Poses poses = views(6);
    for (const std::size_t n : {5u, 3u, 4u}) std::ofstream(poses.views[n].image) << "no picture";
    for (int i = 0; i < 5; ++i) EXPECT_TRUE(names(messageOf<IoError>([&] { readPhotographs(poses); }), "view3.exr"));
    PhotographOptions options;
    options.reduction = 0;
    EXPECT_TRUE(names(messageOf<InvalidArgument>([&] { readPhotographs(poses, options); }), "reduction 0"));
}

TEST_F(PhotographFiles, ReadingCanBeStopped) {
    const Photographs photographs = readPhotographs(views(3), {}, [](const std::string&, double) { return false; });
    EXPECT_FALSE(photographs.complete);
    EXPECT_TRUE(photographs.views.empty());
}

// Looked up in the picture: backdrop, two windows between columns, a column, the wall, a dark crack in it.
TEST_F(PhotographFiles, TempleKeepsItsWindows) {
    const std::string folder = test::findData("photos/temple");
    if (folder.empty()) GTEST_SKIP() << "photos/temple is not on this machine; set RAYSWEEP_DATA";
    Poses poses = readPoses(folder);
    poses.views.resize(1);
    const Photographs photographs = readPhotographs(poses, by(Matting::black));
    const Image& matte = photographs.views[0].matte;
    for (const auto& [x, y] : {std::pair(500, 50), std::pair(320, 222), std::pair(320, 310)})
        EXPECT_EQ(matte.at(x, y)[3], 0) << x << " " << y;
    for (const auto& [x, y] : {std::pair(300, 262), std::pair(480, 220), std::pair(457, 180)})
        EXPECT_EQ(matte.at(x, y)[3], 1) << x << " " << y;
    EXPECT_GT(photographs.reports[0].holes, 0u);
    EXPECT_LT(photographs.reports[0].holePixels, 0.01 * double(photographs.reports[0].covered));
}
