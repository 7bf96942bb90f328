// Pictures and raw samples, and what is done with values, which does not depend on the format.
#include "raysweep/image/image_io.h"

#include <limits>

#include "unit/formats/import_fixture.h"

using namespace raysweep;
using namespace raysweep::test;
using openvdb::Coord;

TEST_F(Import, TiffPagesAreSlices) {
    std::vector<std::vector<std::uint16_t>> pages;
    for (int k = 0; k < 5; ++k) {
        pages.emplace_back();
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 3; ++i) pages.back().push_back(std::uint16_t(label(i, j, k)));
    }
    writeFile(folder / "a.tif", tiffBytes(3, 4, pages));
    ImportOptions options;
    options.spacing = Vec3(0.1, 0.2, 0.3);
    const ImportedVolume volume = importVolume({folder / "a.tif"}, options);
    expectLabels(volume, kDims, 1 / 65535.0);
    EXPECT_EQ(volume.type, SampleType::uint16);
    expectAt(volume, Coord(1, 2, 3), Vec3(0.1, 0.4, 0.9));
}

TEST_F(Import, PicturesOfAFolderAreInNaturalOrder) {
    for (int k = 0; k < 12; ++k)
        writeFile(folder / ("slice" + std::to_string(k) + ".tif"), tiffBytes(1, 1, {{std::uint16_t(k + 1)}}));
    writeFile(folder / "notes.txt", "not a picture");
    ImportOptions options;
    options.normalization = Normalization::none;
    const ImportedVolume volume = importVolume({folder.path().string()}, options);
    EXPECT_EQ(volume.dims, Index3(1, 1, 12));
    for (int k = 0; k < 12; ++k) EXPECT_EQ(volume.grid->tree().getValue(Coord(0, 0, k)), k + 1);
}

TEST_F(Import, PngHasItsBytesNotItsLight) {
    Image image(2, 1, 1);
    image.pixels = {linearFromSrgb(51 / 255.0f), 1};
    writeImage(folder / "a.png", image);
    const ImportedVolume volume = importVolume({folder / "a.png"}, {});
    EXPECT_FLOAT_EQ(volume.grid->tree().getValue(Coord(0, 0, 0)), 0.2f);
    EXPECT_EQ(volume.grid->tree().getValue(Coord(1, 0, 0)), 1.0f);
}

TEST_F(Import, PicturesThatMakeNoVolumeAreRefused) {
    writeFile(folder / "a.tif", tiffBytes(2, 2, {{1, 2, 3, 4}}));
    writeFile(folder / "b.tif", tiffBytes(2, 1, {{1, 2}}));
    expectError({folder / "a.tif", folder / "b.tif"}, "b.tif': its size is 2x1, but the first picture's is 2x2");
    writeImage(folder / "c.png", Image(2, 2, 3));
    expectError({folder / "c.png"}, "3 channels");
    writeImage(folder / "d.png", Image(2, 2, 1));
    expectError({folder / "a.tif", folder / "d.png"}, "uint8");
    expectError({folder.path().string()}, "several kinds (.png, .tif)");
    writeFile(folder / "e.png", "no picture");
    expectError({folder / "e.png"}, "e.png");
    const std::string whole = tiffBytes(2, 2, {{1, 2, 3, 4}});
    writeFile(folder / "f.tif", whole.substr(0, whole.size() - 40));
    expectError({folder / "f.tif"}, "f.tif");
}

TEST_F(Import, RawSamplesOfEveryType) {
    const auto check = [&](auto zero, SampleType type) {
        for (const bool big : {false, true}) {
            writeFile(folder / "a.raw", "HEAD", bytesOf(labels<decltype(zero)>(Index3(3, 4, 1)), big));
            ImportOptions options = rawOptions(Index3(3, 4, 1), type);
            options.raw->bigEndian = big;
            options.raw->skip = 4;
            options.normalization = Normalization::none;
            expectLabels(importVolume({folder / "a.raw"}, options), Index3(3, 4, 1));
        }
    };
    check(std::int8_t{}, SampleType::int8);
    check(std::uint8_t{}, SampleType::uint8);
    check(std::int16_t{}, SampleType::int16);
    check(std::uint16_t{}, SampleType::uint16);
    check(std::int32_t{}, SampleType::int32);
    check(std::uint32_t{}, SampleType::uint32);
    check(std::int64_t{}, SampleType::int64);
    check(std::uint64_t{}, SampleType::uint64);
    check(float{}, SampleType::float32);
    check(double{}, SampleType::float64);
}

TEST_F(Import, RawOfAnotherSizeSaysWhatWouldFit) {
    writeFile(folder / "a.raw", std::string(120, 'x'));
    const std::vector<std::string> file = {folder / "a.raw"};
    expectError(file, "has 120 bytes", rawOptions(Index3(3, 4, 5), SampleType::uint8));
    expectError(file, "such as uint16", rawOptions(Index3(3, 4, 5), SampleType::uint8));
    expectError(file, "dims 3,4,10 of uint8", rawOptions(Index3(3, 4, 5), SampleType::uint8));
    expectError(file, "a header of 20 bytes to skip", rawOptions(Index3(4, 5, 5), SampleType::uint8));
    expectError(file, "check dims, type", rawOptions(Index3(7, 7, 7), SampleType::uint8));
    expectError(file, "at least 1", rawOptions(Index3(3, 0, 5), SampleType::uint8));
}

TEST_F(Import, ValuesAreNormalisedAsDocumented) {
    struct Case {
        SampleType type;
        Normalization how;
        std::optional<double> scale, offset;
        double low, high;  ///< of samples 10 and 210 (of int8: 10 and -46)
    };
    const auto automatic = Normalization::automatic, byType = Normalization::type, data = Normalization::data,
               none = Normalization::none;
    const Case cases[] = {
        {SampleType::uint8, automatic, {}, {}, 10 / 255.0, 210 / 255.0},
        {SampleType::uint8, none, {}, {}, 10, 210},
        {SampleType::uint8, data, {}, {}, 0, 1},
        {SampleType::uint8, automatic, 2.0, 1.0, 21, 421},  // value' = value * scale + offset, of the file's values
        {SampleType::uint8, byType, 2.0, 1.0, 1 + 20 / 255.0, 1 + 420 / 255.0},
        {SampleType::int8, automatic, {}, {}, 10, -46},
        {SampleType::int8, byType, {}, {}, 138 / 255.0, 82 / 255.0},
        {SampleType::int8, data, {}, {}, 1, 0},
    };
    writeFile(folder / "a.raw", bytesOf(std::vector<std::uint8_t>{10, 210}));
    for (const Case& c : cases) {
        ImportOptions options = rawOptions(Index3(2, 1, 1), c.type);
        options.normalization = c.how;
        options.scale = c.scale;
        options.offset = c.offset;
        const ImportedVolume volume = importVolume({folder / "a.raw"}, options);
        const auto value = [&](int i) { return volume.grid->tree().getValue(Coord(i, 0, 0)); };
        EXPECT_FLOAT_EQ(value(0), float(c.low)) << nameOf(c.type) << " " << int(c.how);
        EXPECT_FLOAT_EQ(value(1), float(c.high)) << nameOf(c.type) << " " << int(c.how);
        EXPECT_FLOAT_EQ(float(10 * volume.scale + volume.offset), float(c.low));
    }
    ImportOptions options = rawOptions(Index3(2, 1, 1), SampleType::float32);
    options.normalization = byType;
    writeFile(folder / "f.raw", bytesOf(std::vector<float>{1, 2}));
    expectError({folder / "f.raw"}, "float32", options);
}

TEST_F(Import, BackgroundIsLeftOutAndConstantPartsAreTiles) {
    // 16x8x8: the first half 5, the second 0 but for one voxel.
    std::vector<std::int8_t> samples;
    for (int n = 0; n < 16 * 64; ++n) samples.push_back(n % 16 < 8 ? 5 : 0);
    samples[12] = 1;
    writeFile(folder / "a.raw", bytesOf(samples));
    ImportOptions options = rawOptions(Index3(16, 8, 8), SampleType::int8);
    const auto volume = importVolume({folder / "a.raw"}, options);
    EXPECT_EQ(volume.grid->activeVoxelCount(), 513u);
    EXPECT_EQ(volume.grid->tree().activeTileCount(), 1u);
    EXPECT_EQ(volume.grid->tree().leafCount(), 1u);

    options.tolerance = 1;
    EXPECT_EQ(importVolume({folder / "a.raw"}, options).grid->activeVoxelCount(), 512u);
    options.background = 5;
    options.tolerance = 0;
    const auto other = importVolume({folder / "a.raw"}, options);
    EXPECT_EQ(other.grid->activeVoxelCount(), 512u);
    EXPECT_EQ(other.grid->background(), 5);
    EXPECT_EQ(other.grid->tree().getValue(Coord(3, 3, 3)), 5);
    EXPECT_EQ(other.grid->tree().getValue(Coord(9, 3, 3)), 0);
    EXPECT_TRUE(other.grid->tree().isValueOn(Coord(9, 3, 3)));
}

TEST_F(Import, CropKeepsIndicesAndPlace) {
    writeFile(folder / "a.raw", bytesOf(labels<float>(Index3(20, 10, 9))));
    ImportOptions options = rawOptions(Index3(20, 10, 9), SampleType::float32);
    options.crop = IndexBox{Index3(3, 1, 2), Index3(17, 9, 4)};
    const ImportedVolume volume = importVolume({folder / "a.raw"}, options);
    EXPECT_EQ(volume.grid->evalActiveVoxelBoundingBox(), openvdb::CoordBBox(Coord(3, 1, 2), Coord(17, 9, 4)));
    EXPECT_EQ(volume.grid->activeVoxelCount(), 15u * 9 * 3);
    EXPECT_EQ(volume.grid->tree().getValue(Coord(17, 9, 4)), label(17, 9, 4));
    EXPECT_EQ(volume.range.min, label(3, 1, 2));
    EXPECT_EQ(volume.range.max, label(17, 9, 4));
    expectAt(volume, Coord(3, 1, 2), Vec3(3, 1, 2));
    options.crop->high = Index3(20, 9, 4);
    expectError({folder / "a.raw"}, "last voxel is (19, 9, 8)", options);
}

TEST_F(Import, WhatIsNoNumberIsRefusedOrRepaired) {
    std::vector<float> samples = labels<float>(kDims);
    samples[(2 * 4 + 3) * 3 + 1] = std::numeric_limits<float>::quiet_NaN();
    samples[(4 * 4 + 0) * 3 + 0] = std::numeric_limits<float>::infinity();
    writeFile(folder / "a.raw", bytesOf(samples));
    ImportOptions options = rawOptions(kDims, SampleType::float32);
    expectError({folder / "a.raw"}, "2 voxels are infinite or not a number, the first of them (1, 3, 2)", options);
    options.repair = true;
    const ImportedVolume volume = importVolume({folder / "a.raw"}, options);
    EXPECT_EQ(volume.range.notFinite, 2u);
    EXPECT_EQ(volume.grid->tree().getValue(Coord(1, 3, 2)), 0);
    EXPECT_EQ(volume.grid->activeVoxelCount(), 58u);
    writeFile(folder / "b.raw", bytesOf(std::vector<double>{1e300}));
    expectError({folder / "b.raw"}, "do not fit 32 bit floats", rawOptions(Index3(1), SampleType::float64));
}

TEST_F(Import, OptionsOutOfBoundsAreNamed) {
    ImportOptions options = rawOptions(Index3(1), SampleType::uint8);
    writeFile(folder / "a.raw", "x");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refuse = [&](const std::string& field, const auto& spoil) {
        ImportOptions spoiled = options;
        spoil(spoiled);
        expectError({folder / "a.raw"}, field + " ", spoiled);
    };
    refuse("tolerance", [](auto& o) { o.tolerance = -1; });
    refuse("tolerance", [&](auto& o) { o.tolerance = nan; });
    refuse("background", [&](auto& o) { o.background = nan; });
    refuse("scale", [&](auto& o) { o.scale = nan; });
    refuse("spacing", [](auto& o) { o.spacing = Vec3(1, 0, 1); });
    refuse("crop", [](auto& o) { o.crop = IndexBox{Index3(1, 0, 0), Index3(0)}; });
}

TEST_F(Import, FilesThatCannotBeReadAreNamed) {
    expectError({folder / "missing.nrrd"}, "missing.nrrd': there is no such file");
    expectError({folder / "missing.raw"}, "no such file", rawOptions(Index3(1), SampleType::uint8));
    expectError({folder.path().string()}, "no files at all");
    writeFile(folder / "notes.txt", "hello");
    expectError({folder.path().string()}, "1 other file, such as 'notes.txt'");
    expectError({folder / "notes.txt"}, "no kind that is known");
    writeFile(folder / "a.vdb", "hello");
    expectError({folder / "a.vdb"}, "a .vdb already");
    expectError({}, "no file");
}

TEST_F(Import, StopsWhereItIsAsked) {
    writeFile(folder / "a.raw", bytesOf(labels<float>(Index3(8, 8, 64))));
    const ImportOptions options = rawOptions(Index3(8, 8, 64), SampleType::float32);
    for (const std::string stop : {"reading", "converting"}) {
        const auto progress = [&](const std::string& stage, double) { return stage != stop; };
        EXPECT_FALSE(importVolume({folder / "a.raw"}, options, progress).grid) << stop;
    }
}
