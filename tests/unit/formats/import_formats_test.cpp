// NRRD, MetaImage and NIfTI, written by hand (support/volume_files.h): values, order of axes, place in the world; and
// files that are not what they should be.
#include <cstring>

#include "support/volumes.h"
#include "unit/formats/import_fixture.h"

using namespace raysweep;
using namespace raysweep::test;
using openvdb::Coord;

TEST_F(Import, NrrdKeepsOrderOfAxesAndPlace) {
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

TEST_F(Import, NrrdWithADetachedHeaderAndShearedAxes) {
    writeFile(folder / "a.nhdr",
              "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 4 5\n"
              "space directions: (1,0,0) (0,1,0) (0.5,0,1)\nspace origin: (0,0,0)\n"
              "encoding: raw\nendian: little\ndata file: a.raw\n");
    writeFile(folder / "a.raw", bytesOf(labels<float>(kDims)));
    const ImportedVolume volume = importVolume({folder / "a.nhdr"}, {});
    expectLabels(volume, kDims);
    expectAt(volume, Coord(1, 2, 4), Vec3(3, 2, 4));
}

TEST_F(Import, PositionsInRasBecomeLps) {
    writeFile(folder / "a.nrrd",
              "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: 3 4 5\n"
              "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (5,6,7)\nencoding: raw\nendian: little\n\n",
              bytesOf(labels<std::int16_t>(kDims)));
    const ImportedVolume volume = importVolume({folder / "a.nrrd"}, {});
    expectLabels(volume, kDims);
    expectAt(volume, Coord(1, 1, 1), Vec3(-6, -7, 8));
}

TEST_F(Import, MetaImageKeepsOrderOfAxesAndPlace) {
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

TEST_F(Import, NiftiIsTurnedToLpsAndRescaled) {
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

TEST_F(Import, MalformedOrTruncatedFilesAreNamed) {
    const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n";
    const std::string meta = "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n";
    const std::string samples(63, 'x');  // one too few
    struct Case {
        std::string name, bytes, part;
    };
    NiftiImage nifti{{2, 2, 2}, std::vector<std::int16_t>(7)};
    const Case cases[] = {
        {"a.nrrd", nrrd + samples, "64 bytes of samples are needed, there are 63"},
        {"b.nrrd", "NRRD0004\ntype: word\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n", "type 'word'"},
        {"c.nrrd", "hello", "in its header"},
        {"d.nrrd", "", "in its header"},
        {"e.nhdr", "NRRD0004\ntype: uint8\ndimension: 1\nsizes: 4\nencoding: raw\ndata file: gone.raw\n", "gone.raw"},
        {"a.mha", meta + "ElementDataFile = LOCAL\n" + samples, "data end too early"},
        {"b.mha", "hello", "in its header"},
        {"c.mhd", meta + "ElementDataFile = gone.raw\n", "gone.raw': there is no such file"},
        {"a.nii", niftiBytes(nifti), "data end too early: 16 bytes of samples are needed, there are 14"},
        {"b.nii", std::string(400, 'x'), "not a NIfTI file"},
    };
    for (const Case& c : cases) {
        writeFile(folder / c.name, c.bytes);
        testing::internal::CaptureStderr();
        expectError({folder / c.name}, c.part);
        expectError({folder / c.name}, c.name);
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << c.name << ": a library does not print";
    }
}

TEST_F(Import, TheEngine) {
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
