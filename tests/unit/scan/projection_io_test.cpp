// Projections come back from files as they were written, and files that hold none are refused.
#include "raysweep/scan/projection_io.h"

#include "raysweep/formats/itk_volume.h"
#include "raysweep/image/image_io.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "support/temporary_folder.h"
#include "support/volume_files.h"
#include "unit/scan/ct_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

class ProjectionFiles : public ::testing::Test {
  protected:
    TemporaryFolder folder;
};

class ProjectionMetaImage : public ProjectionFiles {
  protected:
    void SetUp() override {
        if (!hasItk()) GTEST_SKIP() << "this build has no ITK";
    }
};

void expectSame(const Projections& read, const Projections& written) {
    EXPECT_EQ(read.width, written.width);
    EXPECT_EQ(read.height, written.height);
    EXPECT_EQ(read.views, written.views);
    ASSERT_EQ(read.values.size(), written.values.size());
    EXPECT_EQ(std::memcmp(read.values.data(), written.values.data(), 4 * read.values.size()), 0);
}

std::string metaHeader(const std::string& type, bool bigEndian) {
    return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = " +
           std::string(bigEndian ? "True" : "False") +
           "\nOffset = -5 7 0\nElementSpacing = 0.5 0.25 1\nDimSize = 3 2 4\nElementType = " + type +
           "\nElementDataFile = LOCAL\n";
}

}  // namespace

TEST_F(ProjectionMetaImage, RoundTripKeepsBitsAndPlace) {
    const Projections written = numbered(5, 3, 4);
    writeProjections(folder / "p.mha", written, DetectorPair{0.4, 0.8}, DetectorPair{-3.5, 12.25});
    const ProjectionFile read = readProjections({folder / "p.mha"});
    expectSame(read.projections, written);
    ASSERT_TRUE(read.spacing && read.origin);
    EXPECT_EQ(*read.spacing, (DetectorPair{0.4, 0.8}));
    EXPECT_EQ(*read.origin, (DetectorPair{-3.5, 12.25}));
    EXPECT_EQ(read.format, "MetaImage");
}

TEST_F(ProjectionMetaImage, RowsThatCountDownwardsKeepTheirSign) {
    writeProjections(folder / "p.mha", numbered(5, 3, 4), DetectorPair{0.5, -0.25}, DetectorPair{1, 2});
    const ProjectionFile read = readProjections({folder / "p.mha"});
    ASSERT_TRUE(read.spacing && read.origin);
    EXPECT_EQ(*read.spacing, (DetectorPair{0.5, -0.25}));
    EXPECT_EQ(*read.origin, (DetectorPair{1, 2}));
}

TEST_F(ProjectionMetaImage, WithoutAPlaceTheDetectorsMiddleIsAtZero) {
    writeProjections(folder / "p.mha", numbered(5, 3, 4));
    const ProjectionFile read = readProjections({folder / "p.mha"});
    EXPECT_EQ(*read.spacing, (DetectorPair{1, 1}));
    EXPECT_EQ(*read.origin, (DetectorPair{-2, -1}));
}

TEST_F(ProjectionMetaImage, IntegersAreNeitherScaledNorDecoded) {
    std::vector<std::uint16_t> samples;
    for (int n = 0; n < 24; ++n) samples.push_back(std::uint16_t(60000 + 7 * n));
    for (const bool big : {false, true}) {
        writeFile(folder / "p.mha", metaHeader("MET_USHORT", big), bytesOf(samples, big));
        const ProjectionFile read = readProjections({folder / "p.mha"});
        ASSERT_EQ(read.projections.values.size(), samples.size());
        for (std::size_t n = 0; n < samples.size(); ++n) EXPECT_EQ(read.projections.values[n], float(samples[n]));
        EXPECT_EQ(*read.spacing, (DetectorPair{0.5, 0.25}));
        EXPECT_EQ(*read.origin, (DetectorPair{-5, 7}));
    }
}

TEST_F(ProjectionMetaImage, TurnedAxesGiveNoSpacing) {
    writeFile(folder / "p.nrrd",
              "NRRD0004\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: 3 2 4\n"
              "space directions: (0,1,0) (1,0,0) (0,0,1)\nencoding: raw\nendian: little\n\n",
              bytesOf(std::vector<float>(24, 1.0f)));
    const ProjectionFile read = readProjections({folder / "p.nrrd"});
    EXPECT_EQ(read.projections.views, 4);
    EXPECT_FALSE(read.spacing || read.origin);
}

TEST_F(ProjectionMetaImage, TruncatedFileIsAnError) {
    writeProjections(folder / "p.mha", numbered(5, 3, 4));
    std::filesystem::resize_file(folder / "p.mha", std::filesystem::file_size(folder / "p.mha") - 8);
    expectError<IoError>([&] { readProjections({folder / "p.mha"}); }, "p.mha");
}

TEST_F(ProjectionMetaImage, FirstBadValueIsNamedAndRepairLeavesItOut) {
    Projections written = numbered(5, 3, 4);
    written.view(2)[1 * 5 + 3] = kNaN;
    written.view(3)[0] = -kInfinity;
    writeProjections(folder / "p.mha", written);
    expectError<InvalidArgument>([&] { readProjections({folder / "p.mha"}); },
                                 "2 values that are NaN or infinite, the first in view 2, row 1, column 3");
    const ProjectionFile read = readProjections({folder / "p.mha"}, {true});
    EXPECT_TRUE(std::isnan(read.projections.view(2)[8]));
    EXPECT_TRUE(std::isnan(read.projections.view(3)[0]));
    EXPECT_EQ(read.projections.view(2)[7], written.view(2)[7]);
}

TEST_F(ProjectionMetaImage, DoublesBeyondFloatsAreBadValues) {
    std::vector<double> samples(24, 1.0);
    samples[5] = 1e300;
    writeFile(folder / "p.mha", metaHeader("MET_DOUBLE", false), bytesOf(samples));
    expectError<InvalidArgument>([&] { readProjections({folder / "p.mha"}); }, "view 0, row 1, column 2");
}

TEST_F(ProjectionMetaImage, FailedWriteLeavesNothing) {
    expectError<IoError>([&] { writeProjections(folder / "none/p.mha", numbered(2, 2, 2)); }, "create it first");
    EXPECT_TRUE(folder.isEmpty());
}

TEST_F(ProjectionFiles, ExrStackRoundTripIsInNaturalOrder) {
    const Projections written = numbered(5, 3, 12);
    writeProjections(folder / "p.exr", written);
    const std::vector<std::string> files = projectionFiles(folder / "p.exr", 12);
    ASSERT_EQ(files.size(), 12u);
    EXPECT_EQ(files[0], folder / "p_0001.exr");
    EXPECT_EQ(files[11], folder / "p_0012.exr");
    expectSame(readProjections({folder.path().string()}).projections, written);
    const ProjectionFile read = readProjections({files.rbegin(), files.rend()});
    expectSame(read.projections, written);
    EXPECT_FALSE(read.spacing || read.origin) << "pictures have no place";
}

TEST_F(ProjectionFiles, NamesWithoutLeadingZerosAreInNaturalOrderToo) {
    for (const int view : {1, 2, 10}) {
        Image image(2, 1, 1);
        image.pixels = {float(view), 0};
        writeImage(folder / ("v" + std::to_string(view) + ".exr"), image);
    }
    const Projections read = readProjections({folder.path().string()}).projections;
    ASSERT_EQ(read.views, 3);
    EXPECT_EQ(read.view(1)[0], 2.0f);
    EXPECT_EQ(read.view(2)[0], 10.0f);
}

TEST_F(ProjectionFiles, PagesOfOneTiffAreViews) {
    writeFile(folder / "p.tif", tiffBytes(3, 2, {{1, 2, 3, 4, 5, 6}, {11, 12, 13, 14, 15, 65535}}));
    const Projections read = readProjections({folder / "p.tif"}).projections;
    ASSERT_EQ(read.views, 2);
    EXPECT_EQ(read.view(0)[3], 4.0f);
    EXPECT_EQ(read.view(1)[5], 65535.0f);
}

TEST_F(ProjectionFiles, PicturesThatDoNotBelongTogetherAreRefused) {
    writeImage(folder / "a1.exr", Image(3, 2, 1));
    writeImage(folder / "a2.exr", Image(2, 3, 1));
    expectError<InvalidArgument>([&] { readProjections({folder / "a1.exr", folder / "a2.exr"}); }, "a2.exr");
    writeImage(folder / "rgb.exr", Image(3, 2, 3));
    expectError<InvalidArgument>([&] { readProjections({folder / "rgb.exr"}); }, "3 channels");
}

TEST_F(ProjectionFiles, FilesOfOtherKindsAreRefusedByWhatTheyAre) {
    expectError<InvalidArgument>([&] { readProjections({}); }, "no files");
    expectError<InvalidArgument>([&] { readProjections({folder / "geometry.xml"}); }, "it is a geometry");
    expectError<InvalidArgument>([&] { readProjections({folder / "scan.h5"}); }, "counts, not line integrals");
    expectError<InvalidArgument>([&] { readProjections({folder / "scan.hdf"}); }, "counts, not line integrals");
    expectError<InvalidArgument>([&] { readProjections({folder / "volume.vdb"}); }, "it is a sparse volume");
    expectError<IoError>([&] { readProjections({folder / "p.mha"}); }, "no such file");
    expectError<IoError>([&] { writeProjections(folder / "p.tif", numbered(2, 2, 2)); }, "'.tif' is not known");
    expectError<InvalidArgument>([&] { writeProjections(folder / "p.exr", Projections()); }, "must be positive");
    EXPECT_TRUE(folder.isEmpty());
}

TEST_F(ProjectionFiles, StoppedReadingSaysSo) {
    writeProjections(folder / "p.exr", numbered(3, 2, 4));
    const ProjectionFile read =
        readProjections({folder.path().string()}, {}, [](const std::string&, double) { return false; });
    EXPECT_FALSE(read.complete);
}
