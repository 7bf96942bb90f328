#include "raysweep/image/pixel_text.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

using namespace raysweep;

namespace {

std::vector<float> drawn(const std::string& text, int left = 0) {
    Image image(kLetterWidth * 3, kTextHeight, 1);
    drawText(image, left, 0, text, 1);
    return image.pixels;
}

}  // namespace

TEST(PixelText, LettersAreAllDifferentAndTheirStrokesInPlace) {
    std::set<std::vector<float>> seen;
    for (char c = ' '; c <= '~'; ++c) seen.insert(drawn(std::string(1, c)));
    EXPECT_EQ(seen.size(), 95u);
    // Of an L: one upright stroke, and one along the line.
    const std::vector<float> letter = drawn("L");
    std::vector<int> rows;
    for (int y = 0; y < kTextHeight; ++y) {
        int count = 0;
        for (int x = 0; x < 3 * kLetterWidth; ++x) count += letter[std::size_t(y * 3 * kLetterWidth + x)] == 1;
        if (count > 0) rows.push_back(count);
    }
    EXPECT_EQ(rows, (std::vector<int>{1, 1, 1, 1, 1, 1, 1, 1, 1, 7}));
    EXPECT_EQ(textWidth("abc"), 3 * kLetterWidth);
}

TEST(PixelText, WhatIsBeyondThePictureIsLeftOut) {
    EXPECT_EQ(drawn("abcdef"), drawn("abc"));
    EXPECT_EQ(drawn("xabc", -kLetterWidth), drawn("abc"));
    EXPECT_EQ(drawn("\xc3\xa9"), drawn("??"));
}
