// Pictures as other programs write them: palettes, 16 bits, grey with alpha, both kinds of alpha, inks, cut files.
#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/jpeg_check.h"
#include "support/expect_error.h"
#include "support/files.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

using namespace raysweep;

namespace {

/// Two pixels, red and (0,128,255), of a palette; then with alpha 128 for the first.
constexpr const char* kPalette =
    "89504e470d0a1a0a0000000d4948445200000002000000010803000000c3fc8fb800000006504c5445ff00000080ff57"
    "2265c50000000b49444154789c636060040000040002bf7a3f4a0000000049454e44ae426082";
constexpr const char* kPaletteWithAlpha =
    "89504e470d0a1a0a0000000d4948445200000002000000010803000000c3fc8fb800000006504c5445ff00000080ff57"
    "2265c50000000274524e5380ff6012bafe0000000b49444154789c636060040000040002bf7a3f4a0000000049454e44"
    "ae426082";
/// Two pixels of 16 bits, 32768 and 65535.
constexpr const char* kGrey16 =
    "89504e470d0a1a0a0000000d494844520000000200000001100000000081d9fc150000000d49444154789c636860f8ff"
    "1f000502027f165ec4650000000049454e44ae426082";
/// Two pixels of grey and alpha: (128,128), (255,0).
constexpr const char* kGreyAlpha =
    "89504e470d0a1a0a0000000d49484452000000020000000108040000005e2bb7010000000d49444154789c636868f8cf"
    "000005830200d7286e7b0000000049454e44ae426082";
/// One pixel of 16 bits: (65535, 32768, 0) and alpha 32768.
constexpr const char* kColourAlpha16 =
    "89504e470d0a1a0a0000000d49484452000000010000000110060000004f8518ca0000001149444154789c63f8ffbf81"
    "8181a181010012fa02ffcc51d5240000000049454e44ae426082";
/// 12000x12000 pixels, it says; there are none.
constexpr const char* kLarge =
    "89504e470d0a1a0a0000000d4948445200002ee000002ee0080600000051458cf10000000b49444154789c636080020000"
    "090001fb52b8a90000000049454e44ae426082";
/// 8x8 pixels of grey 128.
constexpr const char* kJpeg =
    "ffd8ffe000104a46494600010100000100010000ffdb0043000101010101010101010101010101010101010101010101"
    "0101010101010101010101010101010101010101010101010101010101010101010101010101010101ffc0000b080008"
    "000801011100ffc40014000100000000000000000000000000000000ffc4001410010000000000000000000000000000"
    "0000ffda0008010100003f003fffd9";

std::string fromHex(const std::string& hex) {
    std::string bytes;
    for (std::size_t i = 0; i < hex.size(); i += 2) bytes.push_back(char(std::stoi(hex.substr(i, 2), nullptr, 16)));
    return bytes;
}

/// A TIFF of one row of pixels with 4 channels of 8 bits.
/// @param photometric 2 RGB, 5 CMYK @param extra what the fourth channel is: 1 alpha that is multiplied in, 2 alpha
/// apart; 0 none
std::string tiff(int photometric, int extra, const std::vector<std::uint8_t>& samples) {
    std::string bytes = std::string("II*\0\x08\0\0\0", 8);
    const auto put = [&](std::uint32_t value, int count) {
        for (int i = 0; i < count; ++i) bytes.push_back(char(value >> (8 * i)));
    };
    std::vector<std::array<std::uint32_t, 4>> entries = {
        {256, 4, 1, std::uint32_t(samples.size() / 4)}, {257, 4, 1, 1}, {258, 3, 4, 0}, {259, 4, 1, 1},
        {262, 4, 1, std::uint32_t(photometric)},        {273, 4, 1, 0}, {277, 4, 1, 4}, {278, 4, 1, 1},
        {279, 4, 1, std::uint32_t(samples.size())}};
    if (extra > 0) entries.push_back({338, 4, 1, std::uint32_t(extra)});
    const std::uint32_t bits = std::uint32_t(8 + 2 + 12 * entries.size() + 4);
    put(std::uint32_t(entries.size()), 2);
    for (const auto& [tag, type, count, value] : entries) {
        put(tag, 2), put(type, 2), put(count, 4);
        put(tag == 258 ? bits : tag == 273 ? bits + 8 : value, 4);
    }
    put(0, 4);
    for (int channel = 0; channel < 4; ++channel) put(8, 2);
    return bytes + std::string(samples.begin(), samples.end());
}

class PictureKinds : public testing::Test {
  protected:
    std::string file(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
        return folder_ / name;
    }
    Image read(const std::string& name, const std::string& bytes) const { return readImage(file(name, bytes)); }
    test::TemporaryFolder folder_;
};

/// Floats of one multiplication and one power: a few units in the last place.
void expectPixels(const Image& image, int channels, const std::vector<float>& expected) {
    ASSERT_EQ(image.channels, channels);
    ASSERT_EQ(image.pixels.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(image.pixels[i], expected[i], 4e-7f) << i;
}

float light(int byte) {
    return linearFromSrgb(float(byte) / 255);
}

}  // namespace

TEST_F(PictureKinds, PalettesAreColours) {
    expectPixels(read("a.png", fromHex(kPalette)), 3, {1, 0, 0, 0, light(128), 1});
    const float alpha = 128 / 255.f;
    expectPixels(read("b.png", fromHex(kPaletteWithAlpha)), 4, {alpha, 0, 0, alpha, 0, light(128), 1, 1});
}

TEST_F(PictureKinds, SixteenBitsAreKept) {
    const float half = 32768 / 65535.f;
    expectPixels(read("a.png", fromHex(kGrey16)), 1, {linearFromSrgb(half), 1});
    expectPixels(read("b.png", fromHex(kColourAlpha16)), 4, {half, half * linearFromSrgb(half), 0, half});
}

TEST_F(PictureKinds, GreyWithAlphaIsMultiplied) {
    const float alpha = 128 / 255.f;
    expectPixels(read("a.png", fromHex(kGreyAlpha)), 2, {alpha * light(128), alpha, 0, 0});
}

// A quarter of the light, whichever way the file has it: (255, 128, 0) at alpha 128, apart or multiplied as encoded.
TEST_F(PictureKinds, BothKindsOfAlphaGiveTheSameLight) {
    const float alpha = 128 / 255.f;
    const std::vector<float> expected = {alpha, alpha * light(128), 0, alpha, 0, 0, 0, 0};
    expectPixels(read("apart.tif", tiff(2, 2, {255, 128, 0, 128, 0, 0, 0, 0})), 4, expected);
    const Image multiplied = read("multiplied.tif", tiff(2, 1, {128, 64, 0, 128, 0, 0, 0, 0}));
    ASSERT_EQ(multiplied.channels, 4);
    // 64 stands for 64.25: a quarter of a step of 1/128 of the colour, at a slope below 2.3, times alpha.
    for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_NEAR(multiplied.pixels[i], expected[i], 0.25 / 128 * 2.3 * 0.5) << i;
}

TEST_F(PictureKinds, InksAreRefused) {
    try {
        read("a.tif", tiff(5, 0, {255, 0, 0, 0}));
        FAIL();
    } catch (const IoError& e) {
        EXPECT_NE(std::string(e.what()).find("CMYK"), std::string::npos) << e.what();
        EXPECT_NE(std::string(e.what()).find("a.tif"), std::string::npos) << e.what();
    }
}

TEST_F(PictureKinds, CutJpegsAreRefused) {
    const std::string whole = fromHex(kJpeg);
    const Image image = read("a.jpg", whole);
    ASSERT_EQ(image.pixels.size(), 64u);
    EXPECT_NEAR(image.pixels[0], light(128), 4e-7f);
    EXPECT_FALSE(isCutJpeg(file("more.jpg", whole + "what cameras append")));
    for (std::size_t length = 3; length < whole.size(); ++length) {
        const std::string cut = file("cut.jpg", whole.substr(0, length));
        EXPECT_TRUE(isCutJpeg(cut)) << length;
        EXPECT_THROW(readImage(cut), IoError) << length;
    }
    EXPECT_FALSE(isCutJpeg(file("a.png", fromHex(kGrey16))));
}

// OpenEXR would take gigabytes for what these claim.
TEST_F(PictureKinds, ExrHeadersThatClaimMoreThanTheirFileHoldsAreRefused) {
    writeImage(folder_ / "a.exr", Image(4, 3, 1));
    const std::string whole = test::contentsOf(folder_ / "a.exr");
    const auto with = [&](const std::string& attribute, std::size_t skipped, std::int32_t value) {
        std::string bytes = whole;
        const std::size_t at = bytes.find(attribute) + attribute.size() + skipped;
        for (int n = 0; n < 4; ++n) bytes[at + std::size_t(n)] = char(value >> (8 * n));
        return bytes;
    };
    const std::string window("dataWindow\0box2i", 16), name("compression\0compression", 23);
    EXPECT_EQ(read("same.exr", with(window, 1, 16)).pixels.size(), 12u);
    for (const std::string& bytes : {with(window, 1 + 4 + 12, 1 << 28), with(window, 1 + 4 + 4, -(1 << 30)),
                                     with(name, 1, 1 << 30), with(name, 1, -1)})
        try {
            read("b.exr", bytes);
            ADD_FAILURE() << "was read";
        } catch (const IoError& e) {
            EXPECT_NE(std::string(e.what()).find("longer than the file"), std::string::npos) << e.what();
        }
    for (std::size_t length = 4; length < whole.size(); ++length)
        EXPECT_THROW(read("cut.exr", whole.substr(0, length)), IoError) << length;
}

// 2.3 GB would be taken for 68 bytes.
TEST_F(PictureKinds, PicturesMayNotBeLargerThanTheirFilesCanHold) {
    const std::string path = file("a.png", fromHex(kLarge));
    test::expectError<IoError>([&] { readImage(path); },
                               "a.png': it claims to have more pixels than a file of its size");
    test::expectError<IoError>([&] { readCoverage(path); }, "more pixels than a file of its size can hold");
}

// Coverage 128 of 255 is half a pixel, not the fifth of its light that grey 128 gives.
TEST_F(PictureKinds, MasksAreNotDecoded) {
    const float half = 128 / 255.f;
    Image mask = readCoverage(file("a.jpg", fromHex(kJpeg)));
    ASSERT_EQ(mask.channels, 1);
    EXPECT_NEAR(mask.pixels[0], half, 4e-7f);
    mask = readCoverage(file("b.png", fromHex(kGreyAlpha)));
    expectPixels(mask, 1, {half, 0});
    expectPixels(readCoverage(file("c.png", fromHex(kPaletteWithAlpha))), 1, {half, 1});
    EXPECT_THROW(readCoverage(file("d.png", fromHex(kPalette))), InvalidArgument) << "coloured";
    // Alpha that is 1 everywhere leaves the mask to its grey.
    expectPixels(readCoverage(file("e.tif", tiff(2, 2, {128, 128, 128, 255, 0, 0, 0, 255}))), 1, {half, 0});
}
