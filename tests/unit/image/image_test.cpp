#include "raysweep/core/error.h"
#include "raysweep/core/module.h"
#include "raysweep/image/compare.h"
#include "raysweep/image/image_io.h"
#include "raysweep/image/picture_file.h"

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include <unistd.h>

using namespace raysweep;
namespace fs = std::filesystem;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class ImageFile : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("raysweep_image_test_" + std::to_string(::getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::size_t fileCount() const {
        return std::size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }
    fs::path folder_;
};

/// Values that repeat nowhere, in [0,1).
Image pattern(int width, int height, int channels) {
    Image image(width, height, channels);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = float(std::fmod(0.618034 * double(i), 1.0));
    return image;
}

Image filled(int width, int height, float value) {
    Image image(width, height, 1);
    std::fill(image.pixels.begin(), image.pixels.end(), value);
    return image;
}

}  // namespace

TEST_F(ImageFile, ExrKeepsEveryBit) {
    for (int channels : {1, 3, 4}) {
        Image image = pattern(7, 5, channels);
        image.pixels[0] = 12345.678f;
        image.pixels[1] = -2.5e-12f;
        writeImage(path("a.exr"), image);
        const Image read = readImage(path("a.exr"));
        ASSERT_EQ(read.width, 7);
        ASSERT_EQ(read.height, 5);
        ASSERT_EQ(read.channels, channels);
        EXPECT_EQ(read.pixels, image.pixels);
    }
    EXPECT_EQ(fileCount(), 1u) << "no temporary may stay";
}

// 8 bits of sRGB: half a step is 0.5/255 encoded, and the curve's slope is at most 2.3 in linear light.
TEST_F(ImageFile, PngRoundTripsWithinHalfAStep) {
    for (int channels : {1, 3}) {
        const Image image = pattern(9, 4, channels);
        writeImage(path("a.png"), image);
        const Image read = readImage(path("a.png"));
        ASSERT_EQ(read.channels, channels);
        EXPECT_LT(compareImages(read, image).maxDifference, 2.3 * 0.5 / 255);
    }
}

TEST_F(ImageFile, PngKeepsColourBehindPartialAlpha) {
    Image image(2, 1, 4);
    image.pixels = {0.2f, 0.1f, 0.05f, 0.4f, 0, 0, 0, 0};
    writeImage(path("a.png"), image);
    const Image read = readImage(path("a.png"));
    ASSERT_EQ(read.channels, 4);
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(read.pixels[i], image.pixels[i], 0.4 * 2.3 * 0.5 / 255 + 0.5 / 255) << i;
}

TEST_F(ImageFile, PngStoresTheSrgbCurve) {
    Image image(4, 1, 1);
    image.pixels = {0.21404114f, 1.0f, kNaN, -3.0f};  // encoded: 0.5, 1, and what cannot be shown becomes 0
    writeImage(path("a.png"), image);
    const Image read = readImage(path("a.png"));
    EXPECT_FLOAT_EQ(read.pixels[0], linearFromSrgb(128 / 255.f));  // 0.5 * 255 rounds up
    EXPECT_EQ(read.pixels[1], 1);
    EXPECT_EQ(read.pixels[2], 0);
    EXPECT_EQ(read.pixels[3], 0);
}

TEST_F(ImageFile, RowZeroIsOnTop) {
    Image image(1, 2, 3);
    image.pixels = {1, 1, 1, 0, 0, 0};
    writeImage(path("a.png"), image);
    EXPECT_EQ(readImage(path("a.png")).at(0, 0)[0], 1);
}

TEST_F(ImageFile, SizeIsThatOfThePictureThatWouldBeRead) {
    for (const char* name : {"a.exr", "a.png"}) {
        writeImage(path(name), pattern(7, 5, 3));
        const PictureSize size = pictureSize(path(name));
        EXPECT_EQ(size.width, 7);
        EXPECT_EQ(size.height, 5);
    }
    EXPECT_THROW(pictureSize(path("none.png")), IoError);
}

TEST_F(ImageFile, ErrorsSayWhatAndWhere) {
    EXPECT_THROW(readImage(path("missing.exr")), IoError);
    EXPECT_THROW(readImage(folder_.string()), IoError);
    std::ofstream(path("broken.exr")) << "this is no picture";
    EXPECT_THROW(readImage(path("broken.exr")), IoError);
    // The head of an OpenVDB file, which the image library cannot bear.
    std::ofstream(path("volume.exr")) << std::string(" BDV\0\0\0\0\xe0\0\0\0", 12);
    EXPECT_THROW(readImage(path("volume.exr")), IoError);
    EXPECT_THROW(writeImage(path("a.bmpx"), filled(2, 2, 0)), IoError);
    EXPECT_THROW(writeImage(path("no/such/folder/a.exr"), filled(2, 2, 0)), IoError);
    EXPECT_THROW(writeImage(path("a.exr"), Image()), InvalidArgument);
    EXPECT_THROW(writeImage(path("a.png"), Image(2, 2, 5)), InvalidArgument);
    try {
        writeImage(path("a.jpg"), filled(2, 2, 0));
        FAIL();
    } catch (const IoError& e) {
        EXPECT_NE(std::string(e.what()).find("a.jpg"), std::string::npos);
        EXPECT_NE(std::string(e.what()).find(".exr or .png"), std::string::npos);
    }
}

TEST_F(ImageFile, TruncatedFilesAreRefused) {
#ifdef __SANITIZE_ADDRESS__
    const __lsan::ScopedDisabler notOurs;  // OpenImageIO leaks a string when libpng jumps out of a truncated file
#endif
    for (const char* name : {"a.exr", "a.png"}) {
        writeImage(path(name), pattern(64, 64, 3));
        fs::resize_file(path(name), fs::file_size(path(name)) / 2);
        EXPECT_THROW(readImage(path(name)), IoError) << name;
    }
}

// What other programs write: windows that do not begin at 0, layers in any order, tiles.
TEST_F(ImageFile, ExrOfOtherProgramsIsReadInTheOrderPeopleExpect) {
    const std::vector<std::string> expected = {"R", "G", "B", "A", "Z", "id", "N.X", "N.Y", "N.Z", "glow.R", "glow.G"};
    const Imath::Box2i window({3, -2}, {19, 10});
    constexpr std::size_t kWidth = 17, kPixels = 17 * 13;
    Imf::Header header(Imath::Box2i({0, 0}, {30, 20}), window);
    header.setTileDescription(Imf::TileDescription(8, 8, Imf::MIPMAP_LEVELS));
    std::vector<float> values(kPixels * expected.size());
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < expected.size(); ++c) {
        float* const plane = values.data() + c * kPixels;
        for (std::size_t i = 0; i < kPixels; ++i) plane[i] = float(c) + float(i) / 1000;
        header.channels().insert(expected[c], Imf::Channel(Imf::FLOAT));
        frame.insert(expected[c], Imf::Slice::Make(Imf::FLOAT, plane, window, 4, 4 * kWidth));
    }
    {
        Imf::TiledOutputFile file(path("a.exr").c_str(), header);
        file.setFrameBuffer(frame);
        for (int level = 0; level < file.numLevels(); ++level)
            file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    }
    const Image read = readImage(path("a.exr"));
    ASSERT_EQ(read.width, 17);
    ASSERT_EQ(read.height, 13);
    ASSERT_EQ(read.channels, int(expected.size()));
    for (std::size_t i = 0; i < read.pixels.size(); ++i)
        ASSERT_EQ(read.pixels[i], values[i % expected.size() * kPixels + i / expected.size()]) << i;
}

TEST_F(ImageFile, PartsOfAnExrArePages) {
    const Imath::Box2i window({0, 0}, {4, 2});
    std::vector<Imf::Header> headers(3, Imf::Header(window, window));
    std::vector<std::uint32_t> values(3 * 15);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::uint32_t(4000000000u + i);
    for (std::size_t n = 0; n < 3; ++n) {
        headers[n].setName("slice" + std::to_string(n));
        headers[n].setType(Imf::SCANLINEIMAGE);
        headers[n].channels().insert("Y", Imf::Channel(Imf::UINT));
    }
    {
        Imf::MultiPartOutputFile file(path("a.exr").c_str(), headers.data(), 3);
        for (int n = 0; n < 3; ++n) {
            Imf::OutputPart part(file, n);
            Imf::FrameBuffer frame;
            frame.insert("Y", Imf::Slice::Make(Imf::UINT, values.data() + 15 * n, window, 4, 20));
            part.setFrameBuffer(frame);
            part.writePixels(3);
        }
    }
    const auto file = openStoredPicture(path("a.exr"));
    ASSERT_EQ(file->pages(), 3);
    for (int n = 0; n < 3; ++n) {
        std::vector<std::uint32_t> part(15);
        EXPECT_EQ(file->page(n).type, SampleType::uint32);
        file->readSamples(n, 0, reinterpret_cast<std::byte*>(part.data()));
        EXPECT_EQ(std::memcmp(part.data(), values.data() + 15 * n, 15 * sizeof values[0]), 0) << n;
    }
}

// Subsampled colour is for the image library, which says that it does not know it: an error that crosses from its
// module.
TEST_F(ImageFile, ErrorsOfTheModuleArriveAsOurs) {
    const Imath::Box2i window({0, 0}, {7, 7});
    Imf::Header header(window, window);
    std::vector<float> zero(64);
    Imf::FrameBuffer frame;
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    header.channels().insert("BY", Imf::Channel(Imf::FLOAT, 2, 2));
    frame.insert("Y", Imf::Slice::Make(Imf::FLOAT, zero.data(), window, 4, 32));
    frame.insert("BY", Imf::Slice::Make(Imf::FLOAT, zero.data(), window, 4, 16, 2, 2));
    {
        Imf::OutputFile file(path("a.exr").c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(8);
    }
    try {
        readImage(path("a.exr"));
        FAIL();
    } catch (const IoError& e) {
        EXPECT_NE(std::string(e.what()).find("Subsampled"), std::string::npos) << e.what();
    }
}

TEST(Modules, ThatAreMissingAreLookedForInPlacesThatAreNamed) {
    const ModuleFunction none = moduleFunction("raysweep_nothing", "nothing");
    EXPECT_EQ(none.address, nullptr);
    const std::string beside = fs::read_symlink("/proc/self/exe").parent_path().string();
    EXPECT_NE(none.problem.find("raysweep_nothing.so"), std::string::npos) << none.problem;
    EXPECT_NE(none.problem.find("'" + beside + "'"), std::string::npos) << none.problem;
}

TEST(ToneMap, ScalesByStopsClipsAndDropsAlpha) {
    Image image(2, 1, 4);
    image.pixels = {0.1f, 0.2f, 0.9f, 0.5f, kNaN, -1, 0, 1};
    const Image shown = toneMap(image, 1);
    ASSERT_EQ(shown.channels, 3);
    EXPECT_EQ(shown.pixels, (std::vector<float>{0.2f, 0.4f, 1, 0, 0, 0}));
    EXPECT_THROW(toneMap(image, kNaN), InvalidArgument);
}

TEST(Srgb, CurvesAreInverse) {
    EXPECT_NEAR(srgbFromLinear(0.5f), 0.7353570f, 1e-6);  // IEC 61966-2-1
    EXPECT_NEAR(srgbFromLinear(0.001f), 0.01292f, 1e-6);
    for (float v = 0; v <= 1; v += 0.01f) EXPECT_NEAR(linearFromSrgb(srgbFromLinear(v)), v, 1e-6);
}

TEST(CompareImages, KnownValues) {
    const ImageDifference d = compareImages(filled(20, 16, 0.6f), filled(20, 16, 0.5f));
    EXPECT_NEAR(d.rmse, 0.1, 1e-7);  // 1e-7: the values are floats
    EXPECT_NEAR(d.relativeRmse, 0.2, 2e-7);
    EXPECT_NEAR(d.psnr, 20, 1e-5);
    EXPECT_NEAR(d.maxDifference, 0.1, 1e-7);
    // Without contrast only the first factor of SSIM is left: (2ab + c1)/(a^2 + b^2 + c1), c1 = 1e-4.
    EXPECT_NEAR(d.ssim, (2 * 0.6 * 0.5 + 1e-4) / (0.36 + 0.25 + 1e-4), 1e-6);
}

TEST(CompareImages, PsnrCountsFromThePeak) {
    EXPECT_NEAR(compareImages(filled(12, 12, 26), filled(12, 12, 0.5f), 255).psnr, 20, 1e-9);
}

TEST(CompareImages, EqualPicturesArePerfect) {
    const Image image = pattern(30, 12, 3);
    const ImageDifference d = compareImages(image, image);
    EXPECT_EQ(d.rmse, 0);
    EXPECT_EQ(d.relativeRmse, 0);
    EXPECT_EQ(d.maxDifference, 0);
    EXPECT_TRUE(std::isinf(d.psnr) && d.psnr > 0);
    EXPECT_NEAR(d.ssim, 1, 1e-12);
}

// Against the definition written out: 2-D Gaussian weights for every window, nothing separable.
TEST(CompareImages, SsimIsThatOfWangEtAl) {
    const Image a = pattern(15, 13, 1);
    Image b = a;
    for (std::size_t i = 0; i < b.pixels.size(); ++i) b.pixels[i] = 0.8f * b.pixels[i] + 0.1f * float(i % 3);
    double sum = 0;
    int windows = 0;
    for (int y = 5; y < 8; ++y)
        for (int x = 5; x < 10; ++x, ++windows) {
            double w = 0, ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
            for (int pass = 0; pass < 2; ++pass) {
                for (int j = -5; j <= 5; ++j)
                    for (int i = -5; i <= 5; ++i) {
                        const double g = std::exp(-(i * i + j * j) / (2 * 1.5 * 1.5));
                        const double va1 = *a.at(x + i, y + j), vb1 = *b.at(x + i, y + j);
                        if (pass == 0)
                            w += g, ma += g * va1, mb += g * vb1;
                        else
                            va += g * (va1 - ma) * (va1 - ma), vb += g * (vb1 - mb) * (vb1 - mb),
                                cov += g * (va1 - ma) * (vb1 - mb);
                    }
                if (pass == 0) ma /= w, mb /= w;
            }
            va /= w, vb /= w, cov /= w;
            sum += (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
        }
    EXPECT_NEAR(compareImages(a, b).ssim, sum / windows, 1e-12);
}

TEST(CompareImages, SmallPicturesGetASmallerWindow) {
    EXPECT_NEAR(compareImages(pattern(4, 3, 1), pattern(4, 3, 1)).ssim, 1, 1e-12);
    EXPECT_NEAR(compareImages(filled(1, 1, 0.6f), filled(1, 1, 0.5f)).ssim, 0.6001 / 0.6101, 1e-6);
}

TEST(CompareImages, NaNPassesNoThreshold) {
    Image bad = filled(40, 40, 0.5f);
    bad.pixels[3] = kNaN;
    const ImageDifference d = compareImages(bad, filled(40, 40, 0.5f));
    for (double figure : {d.rmse, d.relativeRmse, d.psnr, d.ssim, d.maxDifference}) EXPECT_TRUE(std::isnan(figure));
}

TEST(CompareImages, ShapesMustAgree) {
    EXPECT_THROW(compareImages(Image(2, 3, 1), Image(3, 2, 1)), InvalidArgument);
    EXPECT_THROW(compareImages(Image(2, 3, 1), Image(2, 3, 3)), InvalidArgument);
    EXPECT_THROW(compareImages(Image(), Image()), InvalidArgument);
    EXPECT_THROW(compareImages(filled(2, 2, 0), filled(2, 2, 0), 0), InvalidArgument);
}

TEST(ComparePictures, AlphaIsComparedApartFromColours) {
    Image a(2, 1, 4), b(2, 1, 4);
    a.pixels = {0.5f, 0.5f, 0.5f, 1, 0.5f, 0.5f, 0.5f, 1};
    b.pixels = {0.5f, 0.5f, 0.5f, 1, 0.5f, 0.5f, 0.5f, 0};
    const PictureDifference difference = comparePictures(a, b);
    EXPECT_EQ(difference.color.rmse, 0);
    ASSERT_TRUE(difference.alpha.has_value());
    EXPECT_DOUBLE_EQ(difference.alpha->rmse, std::sqrt(0.5));
    EXPECT_EQ(difference.alpha->maxDifference, 1);

    // A picture without alpha is opaque.
    Image opaque(2, 1, 3);
    opaque.pixels.assign(6, 0.5f);
    EXPECT_EQ(comparePictures(opaque, b).color.rmse, 0);
    EXPECT_DOUBLE_EQ(comparePictures(opaque, b).alpha->rmse, std::sqrt(0.5));
    EXPECT_FALSE(comparePictures(Image(2, 1, 3), Image(2, 1, 3)).alpha.has_value());
    EXPECT_THROW(comparePictures(Image(2, 1, 4), Image(2, 1, 1)), InvalidArgument);
}
