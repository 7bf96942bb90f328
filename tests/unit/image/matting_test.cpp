// Mattes against pictures that were composited from known ones.
#include "raysweep/image/matting.h"
#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"
#include "support/worst.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

using namespace raysweep;
using Matting = MattingOptions::Matting;

namespace {

/// All of 0, 0.1 ... 1 for alpha and each straight colour: 121 x 121 pixels, RGBA premultiplied.
Image grid() {
    Image image(121, 121, 4);
    for (int p = 0; p < 121 * 121; ++p) {
        const float alpha = float(p % 11) / 10;
        float* const to = image.pixels.data() + 4 * p;
        to[0] = alpha * float(p / 11 % 11) / 10, to[1] = alpha * float(p / 121 % 11) / 10;
        to[2] = alpha * float(p / 1331) / 10, to[3] = alpha;
    }
    return image;
}

/// `object` (RGBA) before a backdrop: C = Co + (1 - alpha) B.
Image before(const Image& object, const Color& backdrop) {
    Image picture(object.width, object.height, 3);
    for (std::size_t p = 0; p < object.pixels.size() / 4; ++p)
        for (int c = 0; c < 3; ++c)
            picture.pixels[3 * p + std::size_t(c)] =
                object.pixels[4 * p + std::size_t(c)] + (1 - object.pixels[4 * p + 3]) * backdrop[c];
    return picture;
}

/// As a file of 8 bits gives it back.
Image rounded(Image picture) {
    for (float& value : picture.pixels) value = linearFromSrgb(std::round(255 * srgbFromLinear(value)) / 255);
    return picture;
}

float worstDifference(const Image& a, const Image& b) {
    float worst = a.pixels.size() == b.pixels.size() ? 0 : std::numeric_limits<float>::quiet_NaN();
    for (std::size_t i = 0; i < a.pixels.size() && i < b.pixels.size(); ++i)
        test::raiseTo(worst, std::abs(a.pixels[i] - b.pixels[i]));
    return worst;
}

MattingOptions by(Matting matting) {
    MattingOptions options;
    options.matting = matting;
    return options;
}

/// A disc of radius `radius` with a soft edge of `edge` pixels and the colour of each pixel.
Image disc(int size, double radius, double edge, const std::function<Color(int, int)>& colour) {
    Image image(size, size, 4);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const double r = std::hypot(x + 0.5 - size / 2.0, y + 0.5 - size / 2.0);
            const float alpha = float(std::min(1.0, std::max(0.0, (radius - r) / edge + 0.5)));
            const Color c = colour(x, y) * alpha;
            float* const to = image.at(x, y);
            to[0] = c.x, to[1] = c.y, to[2] = c.z, to[3] = alpha;
        }
    return image;
}

Color texture(int x, int y) {
    return Color(0.5f + 0.4f * float(std::sin(0.9 * x)), 0.5f + 0.4f * float(std::sin(0.7 * y + 0.3 * x)),
                 0.2f + 0.1f * float(std::sin(1.1 * (x + y))));
}

Image moved(const Image& image, int dx, int dy) {
    Image result(image.width, image.height, image.channels);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const int fromX = std::min(std::max(x - dx, 0), image.width - 1);
            const int fromY = std::min(std::max(y - dy, 0), image.height - 1);
            std::copy_n(image.at(fromX, fromY), image.channels, result.at(x, y));
        }
    return result;
}

std::string messageOf(const std::function<void()>& call) {
    try {
        call();
    } catch (const InvalidArgument& e) {
        return e.what();
    }
    return "";
}

bool names(const std::string& message, const std::string& word) {
    return message.find(word) != std::string::npos;
}

}  // namespace

// Roundings of floats up to 2, of 6e-8 each, which mostly cancel: 8.2e-8 was found.
TEST(Matting, PairGivesBackWhatWasComposited) {
    const Image object = grid();
    const Matte matte = matteOfPair(before(object, grey(1)), before(object, grey(0)));
    EXPECT_LT(worstDifference(matte.image, object), 9e-8f);
    EXPECT_EQ(matte.report.inconsistent, 0u);
    EXPECT_EQ(matte.report.pixels, 121u * 121u);
    EXPECT_FALSE(matte.report.misregistration);
    // Alphas 0 to 1 in steps of 0.1, each 1331 times.
    EXPECT_NEAR(matte.report.coverage, 5.5 * 1331, 1e-6 * 121 * 121);
}

// Any two backdrops do; rounding grows by up to sqrt(3)/|W - B| = 2.1 as the two are nearer to each other:
// 1.2e-7 was found.
TEST(Matting, PairTakesAnyTwoBackdrops) {
    MattingOptions options = by(Matting::whiteBlack);
    options.whiteBackdrop = Color(0.9f, 0.3f, 0.1f);
    options.blackBackdrop = Color(0.1f, 0.2f, 0.3f);
    const Image object = grid();
    const Matte matte =
        matteOf({before(object, options.whiteBackdrop), before(object, options.blackBackdrop)}, options);
    EXPECT_LT(worstDifference(matte.image, object), 1.3e-7f);
    EXPECT_EQ(matte.report.inconsistent, 0u);
}

// 8 bits: a value is off by half a step, 0.5/255, times the slope of the sRGB curve's inverse, at most 2.4/1.055
// = 2.275: d = 0.00446. 1 - alpha is the mean of three differences, off by 2 d, and Co = (Cw + Cb - (1 - alpha))/2 by 2
// d.
TEST(Matting, PairOfEightBitsIsAsGoodAsItsRounding) {
    const float limit = 2 * 2.275f * 0.5f / 255;
    const Image object = grid();
    const Matte matte = matteOfPair(rounded(before(object, grey(1))), rounded(before(object, grey(0))));
    EXPECT_LT(worstDifference(matte.image, object), limit);
    EXPECT_EQ(matte.report.inconsistent, 0u) << "the tolerance is beyond rounding";
    // The tolerance's bound: a channel is 4/3 of 2 d away from the mean of three.
    MattingOptions strict = by(Matting::whiteBlack);
    strict.tolerance = 4.0 / 3 * double(limit);
    EXPECT_LT(strict.tolerance, 0.012);
    EXPECT_EQ(
        matteOfPair(rounded(before(object, grey(1))), rounded(before(object, grey(0))), strict).report.inconsistent,
        0u);
}

// The other way round: least squares is where no neighbour fits better.
TEST(Matting, PairIsTheLeastSquaresSolution) {
    const Color onWhite(0.7f, 0.55f, 0.62f), onBlack(0.31f, 0.2f, 0.15f);
    Image w(1, 1, 3), b(1, 1, 3);
    for (int c = 0; c < 3; ++c) w.pixels[std::size_t(c)] = onWhite[c], b.pixels[std::size_t(c)] = onBlack[c];
    const Image found = matteOfPair(w, b).image;
    const auto misfit = [&](const std::array<double, 4>& x) {
        double sum = 0;
        for (int c = 0; c < 3; ++c) {
            const double atWhite = x[std::size_t(c)] + (1 - x[3]) - double(onWhite[c]);
            const double atBlack = x[std::size_t(c)] - double(onBlack[c]);
            sum += atWhite * atWhite + atBlack * atBlack;
        }
        return sum;
    };
    std::array<double, 4> x;
    std::copy_n(found.pixels.begin(), 4, x.begin());
    const double least = misfit(x);
    for (std::size_t i = 0; i < 4; ++i)
        for (const double step : {-1e-3, 1e-3}) {
            std::array<double, 4> other = x;
            other[i] += step;
            EXPECT_GT(misfit(other), least) << i;
        }
}

TEST(Matting, PairCountsWhatCannotBe) {
    const Image object = grid();
    Image onWhite = before(object, grey(1)), onBlack = before(object, grey(0));
    // Pixels of alpha 1 that get darker before white: alpha above 1.
    for (const int p : {10, 21, 5000 / 11 * 11 + 10})
        for (int c = 0; c < 3; ++c) onWhite.pixels[std::size_t(3 * p + c)] -= 0.06f;
    // A pixel of alpha 0 that is brighter than the backdrop: alpha below 0.
    for (int c = 0; c < 3; ++c) onWhite.pixels[std::size_t(3 * 11 + c)] += 0.06f;
    // One channel that differs by 0.09: 0.06 from the mean of the three. A second one below the tolerance.
    onWhite.pixels[3 * 5] += 0.09f;
    onWhite.pixels[3 * 6] += 0.06f;
    const Matte matte = matteOfPair(onWhite, onBlack);
    EXPECT_EQ(matte.report.outOfRange, 4u);
    EXPECT_EQ(matte.report.disagreeing, 1u);
    EXPECT_EQ(matte.report.inconsistent, 5u);
    EXPECT_EQ(std::count(matte.inconsistent.begin(), matte.inconsistent.end(), 1), 5);
    for (const std::size_t p : {std::size_t(10), std::size_t(21), std::size_t(11), std::size_t(5)})
        EXPECT_TRUE(matte.inconsistent[p]) << p;
    for (std::size_t i = 3; i < matte.image.pixels.size(); i += 4) {
        ASSERT_GE(matte.image.pixels[i], 0);
        ASSERT_LE(matte.image.pixels[i], 1);
    }
}

TEST(Matting, MisregistrationIsFoundExactly) {
    const Image object = disc(90, 30, 3, texture);
    const Image onWhite = rounded(before(object, grey(1))), onBlack = rounded(before(object, grey(0)));
    for (const auto& [x, y] : {std::pair(2, -1), std::pair(-7, 8), std::pair(1, 0), std::pair(0, -3)}) {
        const Matte matte = matteOfPair(onWhite, moved(onBlack, x, y));
        ASSERT_TRUE(matte.report.misregistration) << x << " " << y;
        EXPECT_EQ(matte.report.misregistration->x, x);
        EXPECT_EQ(matte.report.misregistration->y, y);
        EXPECT_LT(matte.report.misregistration->inconsistencyThen, 0.01 * matte.report.misregistration->inconsistency);
        EXPECT_GT(matte.report.inconsistent, 100u);
    }
    EXPECT_FALSE(matteOfPair(onWhite, onBlack).report.misregistration);
    // Too far to be found, and not looked for: nothing is made up.
    MattingOptions near = by(Matting::whiteBlack);
    near.searchRadius = 0;
    EXPECT_FALSE(matteOfPair(onWhite, moved(onBlack, 2, 0), near).report.misregistration);
}

// What changes between two exposures is no shift: noise of a camera, a darker second picture.
TEST(Matting, NoiseIsNoMisregistration) {
    const Image object = disc(90, 30, 3, texture);
    Image onWhite = before(object, grey(1)), onBlack = before(object, grey(0));
    unsigned state = 1;
    const auto noise = [&state] {
        state = state * 1664525u + 1013904223u;
        return 0.03f * (float(state >> 8) / float(1 << 24) - 0.5f);
    };
    for (float& value : onWhite.pixels) value += noise();
    for (float& value : onBlack.pixels) value = std::max(0.0f, 0.97f * value + noise());
    EXPECT_FALSE(matteOfPair(onWhite, onBlack).report.misregistration);
}

TEST(Matting, AlphaOfThePictureIsKept) {
    const Image object = grid();
    const Matte matte = matteOfAlpha(object);
    EXPECT_EQ(matte.image.pixels, object.pixels);
    EXPECT_EQ(matte.report.inconsistent, 0u);
    Image straight = object;
    for (std::size_t p = 0; p < straight.pixels.size(); p += 4)
        for (std::size_t c = 0; c < 3; ++c)
            if (straight.pixels[p + 3] > 0) straight.pixels[p + c] /= straight.pixels[p + 3];
    MattingOptions options;
    options.straightAlpha = true;
    EXPECT_LT(worstDifference(matteOfAlpha(straight, options).image, object), 2e-7f);  // a division, a product
    Image greyAlpha(1, 1, 2);
    greyAlpha.pixels = {0.25f, 0.5f};
    EXPECT_EQ(matteOfAlpha(greyAlpha).image.pixels, (std::vector<float>{0.25f, 0.25f, 0.25f, 0.5f}));
}

TEST(Matting, AlphaCountsWhatCannotBe) {
    Image odd(5, 1, 4);
    odd.pixels = {0.3f, 0,     0, 0,    /*light of nothing*/ 0, 0, 0, 1.2f, /*more than all*/ 0, 0, 0, -0.1f,
                  0.2f, -0.2f, 0, 0.5f, /*negative light*/ 0,   0, 0, 1.01f /*rounding*/};
    const Matte matte = matteOfAlpha(odd);
    EXPECT_EQ(matte.report.inconsistent, 4u);
    EXPECT_EQ(matte.report.outOfRange, 3u);
    EXPECT_EQ(matte.inconsistent, (std::vector<char>{1, 1, 1, 1, 0}));
    EXPECT_EQ(matte.image.pixels,
              (std::vector<float>{0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.2f, 0, 0, 0.5f, 0, 0, 0, 1}));
    EXPECT_TRUE(names(messageOf([] { matteOfAlpha(Image(2, 2, 3)); }), "no alpha"));
}

// Colours at the distance `farthest` from the backdrop are exact whatever alpha is: two such colours before blue.
TEST(Matting, KnownBackdropIsExactAtItsDistance) {
    MattingOptions options = by(Matting::known);
    options.backdrop = Color(0.1f, 0.2f, 0.8f);
    options.nearest = 0;
    options.largestHole = 0;
    for (const Color& own : {Color(0.7f, 0.2f, 0.8f), Color(0.1f, 0.2f, 0.2f), Color(0.5f, 0.4f, 0.4f)}) {
        options.farthest = (own - options.backdrop).length();
        const Image object = disc(40, 12, 6, [&](int, int) { return own; });
        const Matte matte = matteOfKnownBackdrop(before(object, options.backdrop), options);
        EXPECT_LT(worstDifference(matte.image, object), 1.3e-7f);  // found: 1.2e-7, two roundings of values up to 1
    }
}

TEST(Matting, KnownBackdropLeavesNoSpill) {
    MattingOptions options = by(Matting::known);
    options.backdrop = Color(0.02f, 0.05f, 0.5f);
    const Color red(0.6f, 0.05f, 0.02f);  // farther than `farthest`
    const Image object = disc(60, 20, 4, [&](int, int) { return red; });
    const Image picture = before(object, options.backdrop);
    const Matte matte = matteOfKnownBackdrop(picture, options);
    double spill = 0, spillBefore = 0;
    for (std::size_t p = 0; p < 3600; ++p) {
        const float *found = &matte.image.pixels[4 * p], *truth = &object.pixels[4 * p];
        EXPECT_EQ(found[3] == 0, truth[3] <= 0.05f / (red - options.backdrop).length()) << p;
        if (truth[3] == 1) {
            ASSERT_EQ(found[3], 1) << p;
        }
        for (int c = 0; c < 3; ++c) ASSERT_LE(found[c], found[3]) << p;
        if (found[3] == 0 || truth[3] == 1) continue;
        spill = std::max(spill, double(found[2] / found[3]));
        spillBefore = std::max(spillBefore, double(picture.pixels[3 * p + 2] / found[3]));
    }
    // Blue of a straight colour at the edge: 1 or more without removal; the ramp that ends before alpha is 1 leaves
    // (1 - alpha) B of what it calls opaque, at most 1 - 0.3/0.75 of 0.5.
    EXPECT_GT(spillBefore, 1);
    EXPECT_LT(spill, 0.32);
}

TEST(Matting, ThresholdRampsFromOneToTwo) {
    for (const bool onWhite : {false, true}) {
        MattingOptions options = by(onWhite ? Matting::white : Matting::black);
        options.largestHole = 0;
        Image picture(5, 1, 3);
        const float values[] = {0, 0.0499f, 0.075f, 0.1001f, 0.9f};  // encoded, away from the backdrop
        const float expected[] = {0, 0, 0.5f, 1, 1};
        for (int x = 0; x < 5; ++x) {
            std::fill_n(picture.at(x, 0), 3, onWhite ? 1.0f : 0.0f);
            picture.at(x, 0)[x % 3] = linearFromSrgb(onWhite ? 1 - values[x] : values[x]);  // one channel is enough
        }
        const Matte matte = matteOf({picture, {}}, options);
        for (int x = 0; x < 5; ++x) {
            const float* const pixel = matte.image.at(x, 0);
            EXPECT_NEAR(pixel[3], expected[x], 1e-5) << x;  // an encoded value of 1 rounded, over 0.05
            for (int c = 0; c < 3; ++c) {
                const float own = picture.at(x, 0)[c] - (1 - pixel[3]) * (onWhite ? 1.0f : 0.0f);
                EXPECT_EQ(pixel[c], std::min(std::max(own, 0.0f), pixel[3])) << x;
            }
        }
        EXPECT_EQ(matte.report.covered, 3u);
        EXPECT_EQ(matte.report.opaque, 2u);
    }
}

// A bright frame of 20x20 pixels at the left border of 30x20: a dark patch of 3x2, a window of 6x6 and a notch that is
// open to the border.
TEST(Matting, SmallHolesAreFilledAndWindowsStay) {
    Image picture(30, 20, 3);
    const auto fill = [&](int left, int top, int width, int height, float value) {
        for (int y = top; y < top + height; ++y)
            for (int x = left; x < left + width; ++x) std::fill_n(picture.at(x, y), 3, value);
    };
    fill(0, 0, 20, 20, 0.5f);
    fill(3, 3, 3, 2, 0.001f);
    fill(10, 10, 6, 6, 0);
    fill(0, 8, 1, 2, 0);
    MattingOptions options = by(Matting::black);
    options.largestHole = 6 / 600.0;
    const Matte matte = matteOfThreshold(picture, options);
    EXPECT_EQ(matte.report.holes, 1u);
    EXPECT_EQ(matte.report.holePixels, 6u);
    EXPECT_EQ(matte.report.covered, 400u - 36 - 2);
    EXPECT_EQ(matte.image.at(4, 4)[3], 1);
    EXPECT_EQ(matte.image.at(4, 4)[0], 0.001f);
    EXPECT_EQ(matte.image.at(12, 12)[3], 0);
    EXPECT_EQ(matte.image.at(0, 8)[3], 0);
    options.largestHole = 36 / 600.0;
    EXPECT_EQ(matteOfThreshold(picture, options).report.holes, 2u);
    options.largestHole = 5.9 / 600;
    EXPECT_EQ(matteOfThreshold(picture, options).report.holes, 0u);
}

TEST(Matting, MasksMultiplyAndMayBeOfAnotherScale) {
    Image picture(2, 2, 3), mask(4, 4, 1);
    std::fill(picture.pixels.begin(), picture.pixels.end(), 0.5f);
    mask.pixels = {1, 1, 0, 0, 1, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0};
    const Matte fine = matteOf({picture, mask}, by(Matting::masks));
    EXPECT_EQ(fine.image.pixels,
              (std::vector<float>{0.5f, 0.5f, 0.5f, 1, 0.125f, 0.125f, 0.125f, 0.25f, 0, 0, 0, 0, 0, 0, 0, 0}));
    Image one(1, 1, 1);
    one.pixels = {0.5f};
    const Matte coarse = matteOfMask(picture, one);
    for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(coarse.image.pixels[i], i % 4 == 3 ? 0.5f : 0.25f);
    Image withAlpha(1, 1, 4);
    withAlpha.pixels = {0.2f, 0.1f, 0, 0.5f};
    EXPECT_EQ(matteOfMask(withAlpha, one).image.pixels, (std::vector<float>{0.1f, 0.05f, 0, 0.25f}));
    for (const auto& [width, height] : {std::pair(3, 3), std::pair(4, 2), std::pair(2, 4), std::pair(2, 1)}) {
        const std::string message = messageOf([&, w = width, h = height] { matteOfMask(picture, Image(w, h, 1)); });
        EXPECT_TRUE(names(message, "2x2")) << message;
        EXPECT_TRUE(names(message, std::to_string(width) + "x" + std::to_string(height))) << message;
    }
}

TEST(Matting, WhatCannotBeUsedIsNamed) {
    const Image picture(2, 2, 3);
    EXPECT_TRUE(names(messageOf([&] { matteOfPair(picture, Image(2, 3, 3)); }), "2x3"));
    EXPECT_TRUE(names(messageOf([&] { matteOfPair(picture, Image()); }), "before black is empty"));
    EXPECT_TRUE(names(messageOf([&] { matteOfPair(picture, Image(2, 2, 4)); }), "alpha below 1"));
    EXPECT_TRUE(names(messageOf([&] { matteOfThreshold(Image(2, 2, 4), by(Matting::black)); }), "alpha below 1"));
    EXPECT_TRUE(names(messageOf([&] { matteOfAlpha(Image(2, 2, 5)); }), "5 channels"));
    Image bad(3, 2, 4);
    bad.pixels[4 * 5 + 1] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(names(messageOf([&] { matteOfAlpha(bad); }), "(2,1)"));
    MattingOptions options;
    EXPECT_NO_THROW(options.validate());
    const auto refuses = [&](const char* field, const std::function<void(MattingOptions&)>& change) {
        MattingOptions changed;
        change(changed);
        EXPECT_TRUE(names(messageOf([&] { changed.validate(); }), field)) << field;
    };
    refuses("backdrop", [](auto& o) { o.backdrop = Color(0, 0, 1.5f); });
    refuses("whiteBackdrop", [](auto& o) { o.whiteBackdrop = o.blackBackdrop; });
    refuses("whiteBackdrop", [](auto& o) { o.whiteBackdrop = grey(-1); });
    refuses("blackBackdrop", [](auto& o) { o.blackBackdrop = grey(std::numeric_limits<float>::quiet_NaN()); });
    refuses("nearest", [](auto& o) { o.nearest = -1; });
    refuses("farthest", [](auto& o) { o.farthest = o.nearest; });
    refuses("threshold", [](auto& o) { o.threshold = 0; });
    refuses("largestHole", [](auto& o) { o.largestHole = 1.1; });
    refuses("tolerance", [](auto& o) { o.tolerance = 0; });
    refuses("searchRadius", [](auto& o) { o.searchRadius = 65; });
}
