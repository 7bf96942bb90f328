// Every format that ITK reads, written by hand (support/volume_files.h): values, order of axes, place in the world; and
// files that are not what they should be.
#include <algorithm>
#include <cstring>

#include "support/volumes.h"
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

TEST_F(ImportItk, NrrdKeepsOrderOfAxesAndPlace) {
    const std::string header =
        "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 4 5\n"
        "space directions: (2,0,0) (0,0,3) (0,-4,0)\nspace origin: (10,20,30)\nencoding: raw\nendian: ";
    for (const bool big : {false, true}) {
        writeFile(folder / "a.nrrd", header + (big ? "big" : "little") + "\n\n",
                  bytesOf(labels<std::int16_t>(kDims), big));
        const ImportedVolume volume = importVolume({folder / "a.nrrd"}, {});
        expectLabels(volume, kDims);
        EXPECT_EQ(volume.type, SampleType::int16);
        EXPECT_EQ(volume.spacing, Vec3(2, 3, 4));
        expectAt(volume, Coord(0, 0, 0), Vec3(10, 20, 30));
        expectAt(volume, Coord(1, 0, 0), Vec3(12, 20, 30));
        expectAt(volume, Coord(0, 1, 0), Vec3(10, 20, 33));
        expectAt(volume, Coord(0, 0, 1), Vec3(10, 16, 30));
    }
}

TEST_F(ImportItk, NrrdWithADetachedHeaderAndShearedAxes) {
    writeFile(folder / "a.nhdr",
              "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 4 5\n"
              "space directions: (1,0,0) (0,1,0) (0.5,0,1)\nspace origin: (0,0,0)\n"
              "encoding: raw\nendian: little\ndata file: a.raw\n");
    writeFile(folder / "a.raw", bytesOf(labels<float>(kDims)));
    const ImportedVolume volume = importVolume({folder / "a.nhdr"}, {});
    expectLabels(volume, kDims);
    expectAt(volume, Coord(1, 2, 4), Vec3(3, 2, 4));
}

TEST_F(ImportItk, PositionsInRasBecomeLps) {
    writeFile(folder / "a.nrrd",
              "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: 3 4 5\n"
              "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (5,6,7)\nencoding: raw\nendian: little\n\n",
              bytesOf(labels<std::int16_t>(kDims)));
    const ImportedVolume volume = importVolume({folder / "a.nrrd"}, {});
    expectLabels(volume, kDims);
    expectAt(volume, Coord(1, 1, 1), Vec3(-6, -7, 8));
}

TEST_F(ImportItk, MetaImageKeepsOrderOfAxesAndPlace) {
    // TransformMatrix holds the directions of the axes, one after the other: i along y, j along -x.
    const std::string header =
        "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementType = MET_SHORT\nElementSpacing = 2 3 4\n"
        "Offset = 1 2 3\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\nBinaryDataByteOrderMSB = False\nElementDataFile = ";
    const std::string samples = bytesOf(labels<std::int16_t>(kDims));
    writeFile(folder / "a.mha", header + "LOCAL\n", samples);
    writeFile(folder / "b.mhd", header + "b.raw\n");
    writeFile(folder / "b.raw", samples);
    for (const char* name : {"a.mha", "b.mhd"}) {
        const ImportedVolume volume = importVolume({folder / name}, {});
        expectLabels(volume, kDims);
        expectAt(volume, Coord(0, 0, 0), Vec3(1, 2, 3));
        expectAt(volume, Coord(1, 0, 0), Vec3(1, 4, 3));
        expectAt(volume, Coord(0, 1, 0), Vec3(-2, 2, 3));
        expectAt(volume, Coord(0, 0, 1), Vec3(1, 2, 7));
    }
}

TEST_F(ImportItk, NiftiIsTurnedToLpsAndRescaled) {
    NiftiImage image{{3, 4, 5}, labels<std::int16_t>(kDims)};
    const float rows[3][4] = {{2, 0, 0, 10}, {0, 3, 0, 20}, {0, 0, 4, 30}};
    std::memcpy(image.rows, rows, sizeof rows);
    writeFile(folder / "a.nii", niftiBytes(image));
    const ImportedVolume volume = importVolume({folder / "a.nii"}, {});
    expectLabels(volume, kDims);
    expectAt(volume, Coord(0, 0, 0), Vec3(-10, -20, 30));
    expectAt(volume, Coord(1, 1, 1), Vec3(-12, -23, 34));

    image.slope = 0.5f;
    writeFile(folder / "b.nii", niftiBytes(image));
    expectLabels(importVolume({folder / "b.nii"}, {}), kDims, 0.5);
}

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
    refuse("in colour (3 samples per pixel)", [](auto& images) {
        for (DicomImage& image : images) image.channels = 3, image.isSigned = false, image.samples.resize(3 * 12);
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

TEST_F(ImportItk, MalformedOrTruncatedFilesAreNamed) {
    const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n";
    const std::string meta = "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n";
    const std::string samples(63, 'x');  // one too few
    struct Case {
        std::string name, bytes, part;
    };
    NiftiImage nifti{{2, 2, 2}, std::vector<std::int16_t>(7)};
    NiftiImage series{{2, 2, 1, 2}, std::vector<std::int16_t>(8)};
    const Case cases[] = {
        {"a.nrrd", nrrd + samples, "in its data: fread got only 63"},
        {"b.nrrd", "NRRD0004\ntype: word\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n",
         "couldn't parse type \"word\""},
        {"c.nrrd", "hello", "in its header"},
        {"d.nrrd", "", "in its header"},
        {"e.nhdr", "NRRD0004\ntype: uint8\ndimension: 1\nsizes: 4\nencoding: raw\ndata file: gone.raw\n", "gone.raw"},
        {"f.nrrd", "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 2 2 2\nencoding: raw\n\n" + samples,
         "4 dimensions: 2 volumes"},
        {"g.nrrd",
         "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 2 2 2\nkinds: RGB-color domain domain domain\nencoding: "
         "raw\n\n" +
             samples,
         "3 numbers per voxel"},
        {"a.mha", meta + "ElementDataFile = LOCAL\n" + samples, "data end too early"},
        {"b.mha", "hello", "in its header"},
        {"c.mhd", meta + "ElementDataFile = gone.raw\n", "c.mhd': in its data"},
        {"a.nii", niftiBytes(nifti), "data end too early: 368 bytes are needed"},
        {"b.nii", std::string(400, 'x'), "not a NIfTI-1 file"},
        {"c.nii", niftiBytes(series), "4 dimensions: 2 volumes of 2x2x1"},
        {"a.dcm", std::string(128, '\0') + "DICM" + samples, "malformed, or ends early"},
    };
    for (const Case& c : cases) {
        writeFile(folder / c.name, c.bytes);
        testing::internal::CaptureStderr();
        expectError({folder / c.name}, c.part);
        expectError({folder / c.name}, c.name);
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << c.name << ": a library does not print";
    }
    std::vector<DicomImage> images{DicomImage()};
    images[0].columns = images[0].rows = 4;
    images[0].samples.resize(16);
    const std::string whole = dicomBytes(images[0]);
    writeFile(folder / "cut.dcm", whole.substr(0, whole.size() - 8));
    expectError({folder / "cut.dcm"}, "cut.dcm");
}

TEST_F(ImportItk, TheEngine) {
    const std::string path = findData("volumes/engine.nrrd");
    if (path.empty()) GTEST_SKIP() << "volumes/engine.nrrd is not on this machine; set RAYSWEEP_DATA";
    const ImportedVolume volume = importVolume({path}, {});
    EXPECT_EQ(volume.dims, Index3(256, 256, 128));
    EXPECT_EQ(volume.type, SampleType::uint8);
    EXPECT_EQ(volume.range.min, 0);
    EXPECT_EQ(volume.range.max, 255);
    EXPECT_EQ(volume.grid->activeVoxelCount(), 5198360u);
    const struct {
        Coord at;
        int value;
    } voxels[] = {{Coord(128, 128, 64), 133},
                  {Coord(0, 0, 0), 0},
                  {Coord(100, 60, 20), 3},
                  {Coord(200, 130, 5), 13},
                  {Coord(255, 255, 127), 10}};
    for (const auto& [at, value] : voxels) EXPECT_FLOAT_EQ(volume.grid->tree().getValue(at), float(value) / 255) << at;
    double sum = 0;
    for (auto it = volume.grid->cbeginValueOn(); it; ++it) sum += *it * double(it.getVoxelCount());
    EXPECT_NEAR(sum * 255 / 187475057, 1, 1e-7);  // floats
}
