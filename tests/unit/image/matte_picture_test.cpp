#include "raysweep/image/matte_picture.h"
#include "raysweep/core/error.h"
#include "raysweep/image/compare.h"
#include "raysweep/image/image_io.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace raysweep;

TEST(MattePicture, ShowsTheMatteAndBesideItAlpha) {
    Image matte(3, 1, 4);
    matte.pixels = {0.8f, 0.4f, 0.2f, 1, 0, 0, 0, 0, 0.1f, 0.1f, 0.1f, 0.5f};
    const Image picture = mattePicture(matte, {0, 1, 0});
    ASSERT_EQ(picture.width, 6);
    ASSERT_EQ(picture.height, 1);
    ASSERT_EQ(picture.channels, 3);
    EXPECT_EQ(picture.at(0, 0)[1], 0.4f);                 // nothing shines through
    EXPECT_EQ(picture.at(1, 0)[0], picture.at(1, 0)[2]);  // the board alone
    EXPECT_NEAR(picture.at(2, 0)[0], 0.1f + 0.5f * picture.at(1, 0)[0], 1e-7);
    EXPECT_EQ(picture.at(3, 0)[0], 1);
    EXPECT_EQ(picture.at(4, 0)[0], 1);
    EXPECT_EQ(picture.at(4, 0)[1], 0);
    EXPECT_NEAR(srgbFromLinear(picture.at(5, 0)[2]), 0.5, 1e-6);  // what a file holds, so that 128 is one half
    EXPECT_THROW(mattePicture(Image(2, 2, 3)), InvalidArgument);
    EXPECT_THROW(mattePicture(matte, {0}), InvalidArgument);
}

TEST(MattePicture, SquaresOfTheBoardAreEightPixels) {
    const Image picture = mattePicture(Image(17, 9, 4));
    const auto board = [&](int x, int y) { return picture.at(x, y)[0]; };
    EXPECT_EQ(board(0, 0), board(7, 7));
    EXPECT_NE(board(7, 0), board(8, 0));
    EXPECT_NE(board(0, 7), board(0, 8));
    EXPECT_EQ(board(0, 0), board(8, 8));
    EXPECT_EQ(board(0, 0), board(16, 0));
}

// What stands in a file with straight colour 0.5 (encoded) and alpha 0.25, before white: 0.25 * 0.5 + 0.75.
TEST(MattePicture, IsShownAsProgramsMixIt) {
    Image picture(2, 1, 4);
    const float colour = 0.25f * linearFromSrgb(0.5f);
    picture.pixels = {colour, colour, colour, 0.25f, 0, 0, 0, 0};
    const Image shown = shownBefore(picture, 1);
    ASSERT_EQ(shown.channels, 3);
    EXPECT_NEAR(shown.pixels[0], 0.875, 1e-6);
    EXPECT_EQ(shown.pixels[3], 1);
    EXPECT_NEAR(shownBefore(picture, 0).pixels[0], 0.125, 1e-6);
    EXPECT_THROW(shownBefore(picture, 2), InvalidArgument);
}

TEST(MattePicture, ReducesByMeansOfSquares) {
    Image picture(5, 4, 2);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x) picture.at(x, y)[0] = float(x + 10 * y), picture.at(x, y)[1] = 1;
    const Image half = reduced(picture, 2);
    ASSERT_EQ(half.width, 2);
    ASSERT_EQ(half.height, 2);
    EXPECT_EQ(half.pixels, (std::vector<float>{5.5f, 1, 7.5f, 1, 25.5f, 1, 27.5f, 1}));
    EXPECT_EQ(reduced(picture, 1).pixels, picture.pixels);
    EXPECT_THROW(reduced(picture, 0), InvalidArgument);
    EXPECT_THROW(reduced(picture, 5), InvalidArgument);
}

TEST(CompareImages, FiguresAloneAreThoseOfTheComparison) {
    Image a(20, 16, 3), b(20, 16, 3);
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        a.pixels[i] = float(std::fmod(0.618034 * double(i), 1.0));
        b.pixels[i] = 0.9f * a.pixels[i];
    }
    EXPECT_EQ(psnr(a, b), compareImages(a, b).psnr);
    EXPECT_EQ(ssim(a, b), compareImages(a, b).ssim);
    EXPECT_NEAR(psnr(a, b, 2) - psnr(a, b), 20 * std::log10(2.0), 1e-12);
}

// Of colours the mean over the three channels, each by itself.
TEST(CompareImages, SsimOfColoursIsTheMeanOfChannels) {
    Image colours(20, 16, 3), reference(20, 16, 3);
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        Image one(20, 16, 1), other(20, 16, 1);
        for (std::size_t i = 0; i < one.pixels.size(); ++i) {
            one.pixels[i] = float(std::fmod(0.618034 * double(i + 100 * std::size_t(c)), 1.0));
            other.pixels[i] = 0.5f + 0.2f * float(c) * (one.pixels[i] - 0.5f);
            colours.pixels[3 * i + std::size_t(c)] = one.pixels[i];
            reference.pixels[3 * i + std::size_t(c)] = other.pixels[i];
        }
        sum += ssim(one, other);
    }
    EXPECT_NEAR(ssim(colours, reference), sum / 3, 1e-12);
}
