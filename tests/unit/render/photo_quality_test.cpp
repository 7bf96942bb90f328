// Judging volumes by photographs: figures that are known exactly, any lens, light that goes along with the camera, and
// which views stand out.
#include "raysweep/render/photo_quality.h"

#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"
#include "raysweep/phantoms/phantom.h"
#include "raysweep/render/rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace raysweep;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;

namespace {

/// A ball with a rim that becomes opaque, red on one side and green on the other.
ColorVolume ball() {
    PhantomOptions options;
    options.size = 32;
    options.soft = 6;
    options.density = 24;
    ColorVolume volume;
    volume.density = makeSphere(options);
    const auto color = Vec3SGrid::create(Vec3s(0.0f));
    color->setTransform(volume.density->transform().copy());
    auto to = color->getAccessor();
    for (auto voxel = volume.density->cbeginValueOn(); voxel; ++voxel)
        to.setValue(voxel.getCoord(), voxel.getCoord().x() < 0 ? Vec3s(0.8f, 0.2f, 0.1f) : Vec3s(0.1f, 0.6f, 0.2f));
    volume.color = extendedColor(*color, *volume.density);
    return volume;
}

std::vector<Camera> camerasAround(const ColorVolume& volume, int count) {
    RigOptions options;
    options.orbit = RigOrbit::sphere;
    options.views = count;
    options.width = 48, options.height = 40;
    return rigCameras(options, worldBounds(*volume.density));
}

std::vector<Photograph> photographsOf(const ColorVolume& volume, const Rig& rig) {
    std::vector<Photograph> photographs;
    shoot({volume.density, 1, volume.color}, rig, [&](std::size_t n, const Image& picture) {
        photographs.push_back({"view" + std::to_string(n), photoCamera(rig.cameras[n]), picture});
    });
    return photographs;
}

std::vector<ViewQuality> withResiduals(const std::vector<double>& residuals) {
    std::vector<ViewQuality> views;
    for (const double residual : residuals) views.push_back({"", 0, 0, residual});
    return views;
}

PhotoCamera turned(PhotoCamera camera, double angle) {
    const Vec3 right = camera.right, forward = camera.forward;
    camera.right = right * std::cos(angle) - forward * std::sin(angle);
    camera.forward = forward * std::cos(angle) + right * std::sin(angle);
    return camera;
}

}  // namespace

TEST(PhotoQuality, WhatWasPhotographedIsMetExactly) {
    const ColorVolume volume = ball();
    Rig rig;
    rig.cameras = camerasAround(volume, 3);
    const PhotoQuality quality = judge(volume, photographsOf(volume, rig));
    ASSERT_EQ(quality.views.size(), 3u);
    EXPECT_TRUE(quality.complete);
    EXPECT_TRUE(std::isinf(quality.psnr));
    EXPECT_NEAR(quality.ssim, 1, 1e-12);  // means of ones
    for (const ViewQuality& view : quality.views) EXPECT_EQ(view.residual, 0);
    EXPECT_EQ(quality.views[1].name, "view1");
}

TEST(PhotoQuality, AnEmptyVolumeShowsTheBackdrop) {
    // An opaque photograph of linear grey L against nothing: E(L) against the backdrop.
    ColorVolume nothing{openvdb::FloatGrid::create(0), Vec3SGrid::create(Vec3s(0.0f)), nullptr};
    Photograph photograph{"grey", photoCamera(Camera()), {}};
    photograph.camera = resized(photograph.camera, 16, 16);
    photograph.matte = Image(16, 16, 4);
    for (std::size_t i = 0; i < photograph.matte.pixels.size(); ++i)
        photograph.matte.pixels[i] = i % 4 == 3 ? 1.0f : 0.2f;
    for (const float backdrop : {1.0f, 0.0f, 0.25f}) {
        PhotoQualityOptions options;
        options.backdrop = backdrop;
        const PhotoQuality quality = judge(nothing, {photograph}, options);
        const double difference = std::abs(double(backdrop) - srgbFromLinear(0.2f));
        EXPECT_NEAR(quality.psnr, -20 * std::log10(difference), 1e-4);  // floats
        EXPECT_NEAR(quality.views[0].residual, difference, 1e-6);
    }
}

TEST(PhotoQuality, HalfCoveredPixelsMixEncodedColors) {
    // Alpha 1/2 of straight colour L: E(L)/2 + backdrop/2, so against nothing the backdrop leaves (E(L) - 1)/2.
    ColorVolume nothing{openvdb::FloatGrid::create(0), Vec3SGrid::create(Vec3s(0.0f)), nullptr};
    Photograph photograph{"half", resized(photoCamera(Camera()), 12, 12), Image(12, 12, 4)};
    for (std::size_t i = 0; i < photograph.matte.pixels.size(); ++i)
        photograph.matte.pixels[i] = i % 4 == 3 ? 0.5f : 0.1f;
    const PhotoQuality quality = judge(nothing, {photograph});
    EXPECT_NEAR(quality.views[0].residual, (1 - srgbFromLinear(0.2f)) / 2, 1e-6);  // floats
}

TEST(PhotoQuality, AnyLens) {
    // Principal point, unequal focal lengths and distortion: what the renderer sees with them is what it is judged by.
    const ColorVolume volume = ball();
    PhotoCamera camera = photoCamera(camerasAround(volume, 1)[0]);
    camera.focalX *= 0.9;
    camera.principalX += 5;
    camera.principalY -= 3;
    camera.distortion = {0.05, -0.01, 0.002, -0.003};
    const Image picture = render(RenderVolume({volume.density, 1, volume.color}), camera).image;
    // Where the ball's middle is projected to, the picture is symmetric to first order; and it lies aside.
    const auto middle = project(camera, Vec3(0));
    ASSERT_TRUE(middle);
    double x = 0, y = 0, alpha = 0;
    for (int j = 0; j < picture.height; ++j)
        for (int i = 0; i < picture.width; ++i) {
            const double a = picture.at(i, j)[3];
            x += a * (i + 0.5), y += a * (j + 0.5), alpha += a;
        }
    EXPECT_NEAR(x / alpha, middle->x, 0.3);  // pixels; found: below 0.2, by perspective and distortion
    EXPECT_NEAR(y / alpha, middle->y, 0.3);
    EXPECT_EQ(judge(volume, {{"lens", camera, picture}}).views[0].residual, 0);
    PhotoCamera plain = camera;
    plain.distortion = {};
    EXPECT_GT(judge(volume, {{"plain", plain, picture}}).views[0].residual, 0.006);  // found: 0.0071
}

TEST(PhotoQuality, LightGoesAlongWithTheCamera) {
    const ColorVolume volume = ball();
    Rig rig;
    rig.cameras = camerasAround(volume, 4);
    rig.shading.ambient = 0.3, rig.shading.diffuse = 0.7;
    const PhotoCamera first = photoCamera(rig.cameras[0]);
    rig.shading.light = first.right * 0.4 + first.down * 0.5 + first.forward;
    const auto photographs = photographsOf(volume, rig);
    PhotoQualityOptions options;
    options.shading = rig.shading;
    options.lampBeside = first;
    const PhotoQuality quality = judge(volume, photographs, options);
    for (const ViewQuality& view : quality.views) EXPECT_LT(view.residual, 1e-5);  // the light's last bits
    options.lampBeside.reset();
    const PhotoQuality still = judge(volume, photographs, options);
    EXPECT_LT(still.views[0].residual, 1e-5);
    EXPECT_GT(still.views[2].residual, 0.05);
}

TEST(PhotoQuality, StopsWhenAsked) {
    const ColorVolume volume = ball();
    Rig rig;
    rig.cameras = camerasAround(volume, 3);
    const auto photographs = photographsOf(volume, rig);
    const PhotoQuality quality =
        judge(volume, photographs, {}, {}, [](const std::string&, double fraction) { return fraction < 0.3; });
    EXPECT_FALSE(quality.complete);
    EXPECT_EQ(quality.views.size(), 1u);  // its end is a third of the work, and too much
}

TEST(PhotoQuality, NamesWhatIsWrong) {
    Photograph photograph{"small", resized(photoCamera(Camera()), 12, 12), Image(11, 12, 4)};
    const ColorVolume volume = ball();
    EXPECT_THROW(judge(volume, {photograph}), InvalidArgument);
    PhotoQualityOptions options;
    options.backdrop = 1.5f;
    EXPECT_THROW(judge(volume, {}, options), InvalidArgument);
    EXPECT_TRUE(std::isnan(judge(volume, {}).psnr));
}

TEST(PhotoQuality, ComparisonsLieBesideEachOther) {
    Image truth(2, 1, 4), shown(2, 1, 4);
    for (float& value : truth.pixels) value = 1;
    for (int i = 0; i < 4; ++i) shown.at(0, 0)[i] = 1;
    const Image picture = comparisonPicture(truth, shown, 0);
    ASSERT_EQ(picture.width, 6);
    EXPECT_EQ(picture.at(1, 0)[0], 1);                             // photograph
    EXPECT_EQ(picture.at(3, 0)[0], 0);                             // nothing there but the backdrop
    EXPECT_NEAR(picture.at(4, 0)[1], linearFromSrgb(0.5f), 1e-6);  // no difference: the middle grey
    EXPECT_EQ(picture.at(5, 0)[2], 0);                             // darker by all there is
}

TEST(ViewsStandingOut, NoneOfANormalSet) {
    EXPECT_TRUE(viewsStandingOut({}).empty());
    EXPECT_TRUE(viewsStandingOut(withResiduals({0.01, 0.01, 0.01, 5})).empty()) << "too few to tell";
    EXPECT_TRUE(viewsStandingOut(withResiduals(std::vector<double>(20, 0.02))).empty());
    EXPECT_TRUE(viewsStandingOut(withResiduals({0, 0, 0, 0, 0, 0.001})).empty()) << "less than rounding to 8 bits";
    // Logarithms that spread by 15 %, as those of real sets do: none of 50 such sets has one.
    std::mt19937 random(1);
    std::normal_distribution<double> spread(0, 0.15);
    for (int set = 0; set < 50; ++set) {
        std::vector<double> residuals;
        for (int n = 0; n < 24; ++n) residuals.push_back(0.05 * std::exp(spread(random)));
        EXPECT_TRUE(viewsStandingOut(withResiduals(residuals)).empty()) << set;
    }
}

TEST(ViewsStandingOut, TheWorstFirst) {
    const auto found = viewsStandingOut(withResiduals({0.02, 0.1, 0.021, 0.019, 0.02, 0.3, 0.022, 0.018, 0.02}));
    EXPECT_EQ(found, (std::vector<std::size_t>{5, 1}));
}

TEST(ViewsStandingOut, ACameraThatWasTurned) {
    // Photographs of the ball, judged with one camera turned by 2 degrees.
    const ColorVolume volume = ball();
    Rig rig;
    rig.cameras = camerasAround(volume, 8);
    auto photographs = photographsOf(volume, rig);
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0, 0.01f);  // as a camera has it, or all others are met exactly
    for (Photograph& photograph : photographs)
        for (std::size_t i = 0; i < photograph.matte.pixels.size(); ++i)
            if (i % 4 != 3 && photograph.matte.pixels[i] > 0)
                photograph.matte.pixels[i] = std::max(0.0f, photograph.matte.pixels[i] + noise(random));
    EXPECT_TRUE(viewsStandingOut(judge(volume, photographs).views).empty());
    photographs[3].camera = turned(photographs[3].camera, 2 * kPi / 180);
    EXPECT_EQ(viewsStandingOut(judge(volume, photographs).views), std::vector<std::size_t>{3});
}
