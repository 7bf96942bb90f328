// Sections show the voxels that they should, in true proportions; the page holds every voxel.
#include "raysweep/formats/sections.h"

#include "raysweep/core/error.h"
#include "raysweep/image/image_io.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "support/expect_error.h"
#include "support/temporary_folder.h"

using namespace raysweep;
using namespace raysweep::test;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Mat4d;
using openvdb::Vec3d;

namespace {

const Index3 kDims(4, 3, 2), kCorner(-1, 10, 7);
const Vec3d kSpacing(1, 2, 3);

/// Where a voxel is from the corner on, as a number: none is a multiple of another's share of the window.
float labelOf(int i, int j, int k) {
    return float(1 + i + 4 * j + 12 * k);
}

FloatGrid::Ptr labelled(const Mat4d& turn = Mat4d::identity()) {
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    grid->setName("density");
    Mat4d matrix = Mat4d::identity();
    matrix.postScale(kSpacing);
    matrix *= turn;
    matrix.postTranslate(Vec3d(5, 6, 7));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    for (int k = 0; k < kDims.z; ++k)
        for (int j = 0; j < kDims.y; ++j)
            for (int i = 0; i < kDims.x; ++i)
                grid->tree().setValue(Coord(kCorner.x + i, kCorner.y + j, kCorner.z + k), labelOf(i, j, k));
    return grid;
}

Sections sections(const FloatGrid::Ptr& grid, const SectionOptions& options = {}) {
    DenseSource source(grid);
    return sectionsOf(source, options);
}

Vec3 worldOf(const FloatGrid& grid, const Vec3d& index) {
    const Vec3d at = grid.indexToWorld(index);
    return Vec3(at.x(), at.y(), at.z());
}

std::string contentsOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Of base64, digit by digit.
std::string decoded(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0, held = 0;
    for (const char c : text) {
        if (c == '=') break;
        bits = bits << 6 | unsigned(digits.find(c)), held += 6;
        if (held >= 8) held -= 8, bytes += char(bits >> held & 255);
    }
    return bytes;
}

/// What the page's slabs hold.
std::string voxelsOf(const std::string& page, std::size_t count) {
    const std::string begin = "<script type=\"text/plain\" class=\"slab\">", end = "</script>";
    std::string voxels;
    for (std::size_t at = 0; (at = page.find(begin, at)) != std::string::npos;) {
        at += begin.size();
        const std::string packed = decoded(page.substr(at, page.find(end, at) - at));
        std::string slab(count, '\0');
        uLongf size = count;
        EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(slab.data()), &size,
                             reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
                  Z_OK);
        voxels += slab.substr(0, size);
    }
    return voxels;
}

}  // namespace

TEST(Sections, GoThroughTheMiddleUnlessToldOtherwise) {
    const Sections middle = sections(labelled());
    EXPECT_EQ(middle.at, Index3(2, 1, 1));
    EXPECT_EQ(middle.corner, kCorner);
    EXPECT_EQ(middle.smallest, 1);
    EXPECT_EQ(middle.largest, 24);
    EXPECT_EQ(middle.window.low, 1);
    EXPECT_EQ(middle.window.high, 24);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 2; ++k) {
                EXPECT_EQ(middle.planes[0][std::size_t(i + 4 * j)], labelOf(i, j, 1));
                EXPECT_EQ(middle.planes[1][std::size_t(i + 4 * k)], labelOf(i, 1, k));
                EXPECT_EQ(middle.planes[2][std::size_t(j + 3 * k)], labelOf(2, j, k));
            }
}

TEST(Sections, MeetInTheVoxelThatHoldsAPlaceOfTheWorld) {
    for (const Mat4d& turn : {Mat4d::identity(), openvdb::math::rotation<Mat4d>(Vec3d(1, 2, -1).unit(), 1.1)}) {
        const FloatGrid::Ptr grid = labelled(turn);
        SectionOptions options;
        options.at = worldOf(*grid, Vec3d(kCorner.x + 2.4, kCorner.y - 0.4, kCorner.z + 0.6));
        const Sections found = sections(grid, options);
        EXPECT_EQ(found.at, Index3(2, 0, 1));
        EXPECT_EQ(found.planes[0].front(), labelOf(0, 0, 1));
        options.at = worldOf(*grid, Vec3d(kCorner.x + 2.4, kCorner.y - 0.6, kCorner.z + 0.6));
        expectError<InvalidArgument>([&] { sections(grid, options); }, "at: ");
    }
    SectionOptions options;
    options.window = GreyWindow{2, 2};
    expectError<InvalidArgument>([&] { sections(labelled(), options); }, "window 2,2");
}

TEST(Sections, AreDrawnInTrueProportions) {
    const Sections middle = sections(labelled());
    const Image image = sectionPicture(middle);
    // 4 + 4 + 6 units wide: 65 pixels a unit are the least whole number for which that is 900 or more.
    constexpr double kScale = 65;
    const auto areaOf = [&](float label) {
        const float grey = linearFromSrgb(float((double(label) - 1) / 23));
        int count = 0;
        for (std::size_t p = 0; p < image.pixels.size(); p += 3) count += image.pixels[p] == grey;
        return count;
    };
    EXPECT_EQ(areaOf(labelOf(2, 1, 1)), kScale * kScale * (1 * 2 + 1 * 3 + 2 * 3)) << "in all three";
    EXPECT_EQ(areaOf(labelOf(1, 2, 1)), kScale * kScale * 2) << "across z only";
    EXPECT_EQ(areaOf(labelOf(3, 1, 0)), kScale * kScale * 3) << "across y only";
    EXPECT_EQ(areaOf(labelOf(2, 0, 0)), kScale * kScale * 6) << "across x only";
    EXPECT_EQ(areaOf(labelOf(1, 0, 0)), 0);
}

TEST(Sections, OfLargeAndOfFlatVolumesFitIntoAPicture) {
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    grid->tree().setValue(Coord(0), 1);
    DenseSource wide(grid, {IndexBox{Index3(0), Index3(7999, 0, 0)}, {}});
    const Image image = sectionPicture(sectionsOf(wide));
    EXPECT_LT(image.width, 4096 + 200) << "with margins and names of axes";
    DenseSource single(grid);
    const Image small = sectionPicture(sectionsOf(single));
    for (const float value : small.pixels) ASSERT_TRUE(std::isfinite(value));
}

TEST(Sections, NameTheWorldsAxesWhereTheGridFollowsThem) {
    DenseLayout layout;
    layout.steps = {Vec3(0, -2, 0), Vec3(0, 0, 1), Vec3(3, 0, 0)};
    EXPECT_EQ(axisName(layout, 0) + axisName(layout, 1) + axisName(layout, 2), "-yzx");
    layout.steps[2] = Vec3(3, 0.1, 0);
    EXPECT_EQ(axisName(layout, 0) + axisName(layout, 1) + axisName(layout, 2), "ijk");
}

TEST(Sections, ScaleBarsHaveRoundLengths) {
    for (const auto& [longest, length] :
         {std::pair(9.9, 5.0), {10.0, 10.0}, {4.9, 2.0}, {0.03, 0.02}, {1999.0, 1000.0}})
        EXPECT_NEAR(scaleLength(longest), length, 1e-12 * length);
}

TEST(SectionPage, HoldsEveryVoxelInEightBits) {
    const TemporaryFolder folder;
    const FloatGrid::Ptr grid = FloatGrid::create(0);
    grid->setName("</script><b>\xff");
    const Index3 dims(5, 4, 19);  // in three slabs
    const auto valueAt = [](int i, int j, int k) { return float(std::sin(i + 5 * j + 20 * k)); };
    for (int k = 0; k < dims.z; ++k)
        for (int j = 0; j < dims.y; ++j)
            for (int i = 0; i < dims.x; ++i) grid->tree().setValue(Coord(i, j, k), valueAt(i, j, k));
    for (const bool given : {false, true}) {
        DenseSource source(grid);
        SectionOptions options;
        if (given) options.window = GreyWindow{-0.5, 0.25};
        const Sections shown = sectionsOf(source, options);
        writeSectionPage(folder / "a.html", source, options, shown);
        const std::string page = contentsOf(folder / "a.html");
        EXPECT_EQ(page.find("</script><b>"), std::string::npos) << "a name is not taken for HTML";
        const std::string voxels = voxelsOf(page, 5 * 4 * 8);
        ASSERT_EQ(voxels.size(), 5u * 4 * 19);
        const double low = given ? -0.5 : shown.smallest, high = given ? 0.25 : shown.largest;
        for (int k = 0, n = 0; k < dims.z; ++k)
            for (int j = 0; j < dims.y; ++j)
                for (int i = 0; i < dims.x; ++i, ++n) {
                    const double wanted = std::clamp((valueAt(i, j, k) - low) / (high - low), 0.0, 1.0) * 255;
                    EXPECT_NEAR((unsigned char)(voxels[std::size_t(n)]), wanted, 0.5 + 1e-6);
                }
    }
}

TEST(SectionPage, IsRefusedWhereNoBrowserHasRoom) {
    const TemporaryFolder folder;
    const FloatGrid::Ptr grid = labelled();
    DenseSource source(grid, {IndexBox{Index3(0), Index3(1 << 11, 1 << 10, 1 << 9)}, {}});
    EXPECT_GT(source.layout().samples(), std::uint64_t(1) << 30);
    Sections unread;
    expectError<InvalidArgument>([&] { writeSectionPage(folder / "a.html", source, {}, unread); },
                                 "2049x1025x513 voxels");
    EXPECT_TRUE(folder.isEmpty());
}
