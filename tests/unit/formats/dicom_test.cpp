// DICOM, written by hand (support/volume_files.h): values, order of slices, place in the world; which slices make a
// volume.
#include <algorithm>
#include <cstring>

#include "support/memory.h"
#include "unit/formats/import_fixture.h"

using namespace raysweep;
using namespace raysweep::test;
using openvdb::Coord;

namespace {

/// `count` slices, 2 mm apart, of a series; file names do not follow the positions.
std::vector<DicomImage> series(int count) {
    std::vector<DicomImage> images;
    const auto all = labels<std::uint16_t>(Index3(kDims.x, kDims.y, count));
    const auto size = std::size_t(kDims.x * kDims.y);
    for (int k = 0; k < count; ++k) {
        DicomImage image;
        image.columns = kDims.x;
        image.rows = kDims.y;
        image.samples.assign(all.begin() + std::ptrdiff_t(size * std::size_t(k)),
                             all.begin() + std::ptrdiff_t(size * std::size_t(k + 1)));
        image.number = count - k;
        image.position = "10\\20\\" + std::to_string(-30 + 2 * k);
        image.spacing = "3\\4";  // between rows (y), between columns (x)
        images.push_back(image);
    }
    return images;
}

std::string writeSeries(const TemporaryFolder& folder, const std::vector<DicomImage>& images,
                        const std::string& prefix = "IM") {
    for (std::size_t n = 0; n < images.size(); ++n)
        writeFile(folder / (prefix + std::to_string((n * 7 + 3) % images.size())), dicomBytes(images[n]));
    return folder.path().string();
}

}  // namespace

TEST_F(ImportItk, DicomSeriesIsSortedByPositionAndCalibrated) {
    std::vector<DicomImage> images = series(5);
    for (DicomImage& image : images) image.slope = "2", image.intercept = "-1024";
    const ImportedVolume volume = importVolume({writeSeries(folder, images)}, {});
    ASSERT_TRUE(volume.grid);
    EXPECT_EQ(volume.dims, kDims);
    EXPECT_EQ(volume.format, "DICOM");
    for (const Coord& at : {Coord(0, 0, 0), Coord(2, 1, 0), Coord(0, 3, 2), Coord(2, 3, 4)})
        EXPECT_EQ(volume.grid->tree().getValue(at), 2 * label(at.x(), at.y(), at.z()) - 1024) << at;
    EXPECT_EQ(volume.spacing, Vec3(4, 3, 2));
    expectAt(volume, Coord(1, 1, 1), Vec3(14, 23, -28));
}

TEST_F(ImportItk, DicomSlicesOfATiltedGantryMakeAShearedGrid) {
    std::vector<DicomImage> images = series(4);
    for (int k = 0; k < 4; ++k)
        images[std::size_t(k)].position = "0\\" + std::to_string(0.5 * k) + "\\" + std::to_string(2 * k);
    const ImportedVolume volume = importVolume({writeSeries(folder, images)}, {});
    expectLabels(volume, Index3(3, 4, 4));
    expectAt(volume, Coord(1, 0, 3), Vec3(4, 1.5, 6));
}

TEST_F(ImportItk, DicomUnsignedValuesStayAsTheyAreMeasured) {
    std::vector<DicomImage> images = series(2);
    for (DicomImage& image : images) image.isSigned = false;
    expectLabels(importVolume({writeSeries(folder, images)}, {}), Index3(3, 4, 2));
}

TEST_F(ImportItk, DicomRescalingMayDifferFromSliceToSlice) {
    std::vector<DicomImage> images = series(3);
    images[1].slope = "0.5";
    images[2].slope = "0.25";
    const ImportedVolume volume = importVolume({writeSeries(folder, images)}, {});
    EXPECT_EQ(volume.grid->tree().getValue(Coord(1, 1, 0)), label(1, 1, 0));
    EXPECT_EQ(volume.grid->tree().getValue(Coord(1, 1, 1)), label(1, 1, 1) * 0.5f);
    EXPECT_EQ(volume.grid->tree().getValue(Coord(1, 1, 2)), label(1, 1, 2) * 0.25f);
}

TEST_F(ImportItk, OneOfSeveralDicomSeriesMustBeChosen) {
    std::vector<DicomImage> other = series(2);
    for (DicomImage& image : other) image.series = "9.8.7", image.description = "foot";
    writeSeries(folder, series(5));
    const std::string path = writeSeries(folder, other, "other");
    expectError({path}, "1.2.3.4  5 images  head");
    expectError({path}, "there are 2 DICOM series; choose one:\n");
    expectError({path}, "9.8.7  2 images  foot");
    ImportOptions options;
    options.series = "9.8.7";
    expectLabels(importVolume({path}, options), Index3(3, 4, 2));
    options.series = "5.5";
    expectError({path}, "no DICOM series '5.5'", options);
}

TEST_F(ImportItk, DicomSlicesThatMakeNoVolumeAreRefused) {
    const auto refuse = [&](const std::string& part, const auto& spoil) {
        const TemporaryFolder own;
        std::vector<DicomImage> images = series(6);
        spoil(images);
        expectError({writeSeries(own, images)}, part);
    };
    refuse("4 mm from", [](auto& images) { images.erase(images.begin() + 2); });
    refuse("0 mm from", [](auto& images) { images[3].position = images[2].position; });
    refuse("turned against each other", [](auto& images) { images[2].orientation = "1\\0\\0\\0\\0\\1"; });
    refuse("does not say where it is", [](auto& images) { images[2].position = ""; });
    refuse("2x4", [](auto& images) { images[2].columns = 2, images[2].samples.resize(8); });
    refuse("holds 3 channels (RGB), but a volume needs one number per voxel; choose one by `channel`: 0 red",
           [](auto& images) {
               for (DicomImage& image : images)
                   image.channels = 3, image.isSigned = false, image.samples.resize(3 * 12);
           });
}

TEST_F(ImportItk, SpacingStandsForDicomPositions) {
    std::vector<DicomImage> images = series(5);
    std::reverse(images.begin(), images.end());
    for (std::size_t n = 0; n < images.size(); ++n) {
        images[n].position = images[n].orientation = "";
        images[n].number = 5 - int(n);  // 1 for the first labels
    }
    ImportOptions options;
    options.spacing = Vec3(1, 2, 3);
    const ImportedVolume volume = importVolume({writeSeries(folder, images)}, options);
    expectLabels(volume, kDims);
    EXPECT_EQ(volume.spacing, Vec3(1, 2, 3));
}

TEST_F(ImportItk, MalformedOrTruncatedDicomIsNamed) {
    writeFile(folder / "a.dcm", std::string(128, '\0') + "DICM" + std::string(63, 'x'));
    expectError({folder / "a.dcm"}, "malformed, or ends early");
    writeFile(folder / "zeros.dcm", std::string(1 << 20, '\0'));
    expectError({folder / "zeros.dcm"}, "it is not DICOM");
    DicomImage image;
    image.columns = image.rows = 4;
    image.samples.resize(16);
    const std::string whole = dicomBytes(image);
    const std::size_t pixels = whole.find(std::string("\xe0\x7f\x10\0", 4));
    writeFile(folder / "zeros.dcm", whole.substr(0, pixels) + std::string(1 << 22, '\0'));  // instead of the pixels
    expectError({folder / "zeros.dcm"}, "there is an element that no data set has");
    writeFile(folder / "more.dcm", whole + std::string(128, 'x'));
    expectError({folder / "more.dcm"}, "malformed, or ends early");
    writeFile(folder / "cut.dcm", whole.substr(0, whole.size() - 8));
    expectError({folder / "cut.dcm"}, "cut.dcm");
    image.frames = 1000000;
    writeFile(folder / "frames.dcm", dicomBytes(image));
    expectError({folder / "frames.dcm"}, "its pixels end early");
    image.frames = 2000000000;
    writeFile(folder / "frames.dcm", dicomBytes(image));
    expectError({folder / "frames.dcm"}, "NumberOfFrames");
}

// Media fill up files with them. To GDCM they would be elements, a million of them in the largest.
TEST_F(ImportItk, ZerosBehindDicomPixelsAreNotRead) {
    DicomImage image = series(1)[0];
    DicomImage packed = image;
    packed.fragments = {dicomRunLengths(image.samples)};
    for (const std::size_t zeros : {1, 2, 3, 7, 128, 1 << 22})
        for (const DicomImage& each : {image, packed}) {
            writeFile(folder / "a.dcm", dicomBytes(each) + std::string(zeros, '\0'));
            const ImportedVolume volume = importVolume({folder / "a.dcm"}, {});
            expectLabels(volume, Index3(3, 4, 1));
            EXPECT_EQ(volume.notes,
                      std::vector<std::string>{"its data go on behind the pixels; the rest was not read"});
        }
}

TEST_F(ImportItk, DicomThatCannotBeUsedIsLeftOutBesideWhatCan) {
    const std::string scan = writeSeries(folder, series(5));
    const auto add = [&](const std::string& name, const auto& spoil) {
        DicomImage image = series(1)[0];
        image.series = "9.8." + std::to_string(name.size());
        spoil(image);
        writeFile(folder / name, dicomBytes(image));
        return image.series;
    };
    const std::string palette = add("report", [](auto& image) { image.photometric = "PALETTE COLOR"; });
    const std::string cut = add("cut", [](auto& image) { image.frames = 7; });
    const std::string slope = add("slope", [](auto& image) { image.slope = "two"; });
    ImportedVolume volume = importVolume({scan}, {});
    expectLabels(volume, kDims);
    ASSERT_EQ(volume.notes.size(), 3u);
    EXPECT_EQ(volume.notes[0].rfind("series 9.8.3 (1 image) was left out: cannot read '", 0), 0u) << volume.notes[0];
    EXPECT_NE(volume.notes[1].find("'two' is no number"), std::string::npos) << volume.notes[1];
    EXPECT_NE(volume.notes[2].find("PALETTE COLOR, not numbers"), std::string::npos) << volume.notes[2];

    ImportOptions options;
    options.series = "1.2.3.4";
    volume = importVolume({scan}, options);
    expectLabels(volume, kDims);
    EXPECT_TRUE(volume.notes.empty());
    options.series = palette;
    expectError({scan}, "PALETTE COLOR, not numbers", options);
    options.series = cut;
    expectError({scan}, "its pixels end early", options);
    expectError({folder / "cut", folder / "slope"}, "its pixels end early");  // there is nothing else
    options.series = "1.2.3.4";
    DicomImage slice = series(6)[5];  // of the scan itself
    slice.frames = 7;
    writeFile(folder / "IM9", dicomBytes(slice));
    expectError({scan}, "IM9': its pixels end early", options);
}

TEST_F(ImportItk, PackedDicomHasAFragmentForEachFrame) {
    DicomImage image = series(1)[0];
    image.frames = 5;
    const auto all = labels<std::uint16_t>(kDims);
    for (auto frame = all.begin(); frame != all.end(); frame += 12)
        image.fragments.push_back(dicomRunLengths({frame, frame + 12}));
    writeFile(folder / "a.dcm", dicomBytes(image));
    ImportOptions options;
    options.spacing = Vec3(1);
    expectLabels(importVolume({folder / "a.dcm"}, options), kDims);
    image.frames = 1000000;  // 6 KB would take 3.6 GB
    writeFile(folder / "a.dcm", dicomBytes(image));
    expectError({folder / "a.dcm"}, "it promises 1000000 frames, there are 5 fragments of pixels", options);
}

// 633 bytes each found, half of them the grid's; with copies of what is the same for all it was 3750.
TEST_F(ImportItk, ManyDicomFramesShareWhatIsTheSame) {
    DicomImage image = series(1)[0];
    image.columns = image.rows = 1;
    image.frames = 200000;
    image.samples.assign(200000, 7);
    writeFile(folder / "a.dcm", dicomBytes(image));
    ImportOptions options;
    options.spacing = Vec3(1);
    ImportedVolume volume;
    const auto taken = test::bytesTaken([&] { volume = importVolume({folder / "a.dcm"}, options); });
    EXPECT_EQ(volume.dims, Index3(1, 1, 200000));
    EXPECT_EQ(volume.grid->tree().getValue(Coord(0, 0, 199999)), 7);
    EXPECT_LT(taken.value_or(0), 200000u * 690);
}

TEST_F(ImportItk, DicomOfMonochrome1HasTheNumbersOfTheFile) {
    std::vector<DicomImage> images = series(3);
    for (DicomImage& image : images)
        image.photometric = "MONOCHROME1", image.isSigned = false, image.bitsStored = 12, image.highBit = 11;
    const ImportedVolume volume = importVolume({writeSeries(folder, images)}, {});
    expectLabels(volume, Index3(3, 4, 3));
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_NE(volume.notes[0].find("MONOCHROME1"), std::string::npos);
}

TEST_F(ImportItk, DicomBitsBesideThoseStoredAreNoNumbers) {
    // 12 bits, signed, and an overlay in the 4 above them.
    std::vector<DicomImage> images = series(2);
    for (DicomImage& image : images) {
        image.bitsStored = 12, image.highBit = 11;
        for (std::uint16_t& sample : image.samples) sample = std::uint16_t((-int(sample) & 0xfff) | 0x5000);
    }
    const ImportedVolume volume = importVolume({writeSeries(folder, images)}, {});
    expectLabels(volume, Index3(3, 4, 2), -1);
}

TEST_F(ImportItk, DicomWithAHighBitFurtherUpIsShiftedDown) {
    std::vector<DicomImage> images = series(2);
    for (DicomImage& image : images) {
        image.isSigned = false, image.bitsStored = 12, image.highBit = 15;
        for (std::uint16_t& sample : image.samples) sample = std::uint16_t(sample << 4 | 0x7);
    }
    expectLabels(importVolume({writeSeries(folder, images)}, {}), Index3(3, 4, 2));
}

TEST_F(ImportItk, DicomPixelsThatAreNoNumbersAreRefused) {
    const auto refuse = [&](const std::string& part, const auto& spoil) {
        const TemporaryFolder own;
        std::vector<DicomImage> images = series(2);
        for (DicomImage& image : images) spoil(image);
        expectError({writeSeries(own, images)}, part);
    };
    refuse("PALETTE COLOR", [](auto& image) { image.photometric = "PALETTE COLOR"; });
    refuse("is a mosaic", [](auto& image) { image.type = "ORIGINAL\\PRIMARY\\M\\MOSAIC"; });
    refuse("slope is 0", [](auto& image) { image.slope = "0"; });
    refuse("'two' is no number", [](auto& image) { image.slope = "two"; });
    refuse("contradict each other", [](auto& image) { image.bitsStored = 17; });
    refuse("not at right angles", [](auto& image) { image.orientation = "1\\0\\0\\0.5\\1\\0"; });
}

TEST_F(ImportItk, DicomPaddingIsSaid) {
    std::vector<DicomImage> images = series(2);
    for (DicomImage& image : images) {
        image.pixels = dicomElement(0x28, 0x120, "SS", std::string("\x30\xf8", 2));  // -2000
        image.samples[5] = std::uint16_t(-2000);
    }
    const ImportedVolume volume = importVolume({writeSeries(folder, images)}, {});
    EXPECT_EQ(volume.grid->tree().getValue(Coord(2, 1, 0)), -2000);
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_EQ(volume.notes[0].rfind("2 voxels hold its padding (-2000", 0), 0u) << volume.notes[0];
}

TEST_F(ImportItk, DicomSeriesOfSeveralVolumesMustBeChosenFrom) {
    // Two echoes and two instants in every place, by the attribute, by both, and by the order of numbers alone.
    const auto write = [&](const TemporaryFolder& own, int echoes, int instants, bool named) {
        std::vector<DicomImage> all;
        for (int n = 0; n < echoes * instants; ++n) {
            std::vector<DicomImage> images = series(3);
            for (DicomImage& image : images) {
                for (std::uint16_t& sample : image.samples) sample = std::uint16_t(sample + 1000 * n);
                if (named) image.acquisition = dicomElement(0x18, 0x86, "IS", std::to_string(1 + n % echoes));
                if (named) image.relation = dicomElement(0x20, 0x100, "IS", std::to_string(1 + n / echoes));
                image.number += 10 * n;
                all.push_back(image);
            }
        }
        return writeSeries(own, all);
    };
    const auto expectVolume = [&](const std::string& path, int n) {
        ImportOptions options;
        options.volumeIndex = n;
        const ImportedVolume volume = importVolume({path}, options);
        EXPECT_EQ(volume.dims, Index3(3, 4, 3));
        for (int k = 0; k < 3; ++k)
            EXPECT_EQ(volume.grid->tree().getValue(Coord(1, 2, k)), label(1, 2, k) + 1000 * n) << n;
        expectAt(volume, Coord(0, 0, 2), Vec3(10, 20, -26));
    };
    const TemporaryFolder echoes, instants, both, unnamed;
    const std::string two = write(echoes, 2, 1, true);
    expectError({two},
                "holds 2 volumes of 3 slices each, and one is wanted; choose one by `volumeIndex`: 0 (echo 1), 1 "
                "(echo 2)");
    for (int n = 0; n < 2; ++n) expectVolume(two, n);
    ImportOptions options;
    options.volumeIndex = 2;
    expectError({two}, "volumeIndex 2: ", options);
    const std::string later = write(instants, 1, 2, true);
    expectError({later}, "1 (temporal position 2)");
    for (int n = 0; n < 2; ++n) expectVolume(later, n);
    const std::string four = write(both, 2, 2, true);
    expectError({four}, "4 volumes of 3 slices");
    expectError({four}, "1 (echo 1, temporal position 2)");
    const std::string numbers = write(unnamed, 2, 1, false);
    expectError({numbers}, "by the order of their numbers alone");
    for (int n = 0; n < 2; ++n) expectVolume(numbers, n);
    options.volumeIndex.reset();
    options.spacing = Vec3(1);  // positions are not asked for, but they tell
    expectError({two}, "holds 2 volumes", options);
}

TEST_F(ImportItk, DicomFramesOfOneFileAreSlices) {
    DicomImage image = series(1)[0];
    image.frames = 5;
    image.samples = labels<std::uint16_t>(kDims);
    const std::string path = folder / "frames.dcm";
    writeFile(path, dicomBytes(image));
    expectError({path}, "does not say where it is");  // one position for all
    ImportOptions options;
    options.spacing = Vec3(1, 2, 3);
    expectLabels(importVolume({path}, options), kDims);

    image.acquisition = dicomElement(0x18, 0x88, "DS", "2.5");  // spacing between slices
    writeFile(path, dicomBytes(image));
    const ImportedVolume volume = importVolume({path}, {});
    expectLabels(volume, kDims);
    expectAt(volume, Coord(0, 0, 4), Vec3(10, 20, -20));
}

TEST_F(ImportItk, OneChannelOfColouredDicomCanBeTaken) {
    std::vector<DicomImage> images = series(2);
    for (DicomImage& image : images) {
        const std::vector<std::uint16_t> grey = image.samples;
        image.channels = 3, image.isSigned = false, image.samples.clear();
        for (const std::uint16_t sample : grey)
            for (int c = 0; c < 3; ++c) image.samples.push_back(std::uint16_t(c == 1 ? sample : 7777));
    }
    ImportOptions options;
    options.channel = 1;
    expectLabels(importVolume({writeSeries(folder, images)}, options), Index3(3, 4, 2));
}
