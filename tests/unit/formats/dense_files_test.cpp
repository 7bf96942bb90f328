// What is written for other programs comes back: the same bits, in the same place. That programs which share no code
// with Raysweep read it so is checked by tests/cli/test_export.sh.
#include "raysweep/formats/dense_files.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "support/expect_error.h"
#include "unit/formats/import_fixture.h"

namespace fs = std::filesystem;
using namespace raysweep;
using namespace raysweep::test;
using openvdb::FloatGrid;
using openvdb::Mat4d;
using openvdb::Vec3d;

namespace {

const Coord kCorner(-3, 5, 13), kLast(16, 9, 24);  // across leaves, from an odd place

/// No two voxels alike, none of them a number with few digits; every seventh is inactive and has the background.
FloatGrid::Ptr labelled(const Mat4d& matrix, float background = 0) {
    const FloatGrid::Ptr grid = FloatGrid::create(background);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    grid->setName("density");
    int n = 0;
    for (auto at = openvdb::CoordBBox(kCorner, kLast).begin(); at; ++at)
        if (++n % 7 != 3) grid->tree().setValue(*at, std::exp(float(n) / 300 - 3));
    return grid;
}

Mat4d placed(const Vec3d& spacing, double angle, bool sheared = false) {
    Mat4d matrix = Mat4d::identity();
    matrix.postScale(spacing);
    if (sheared) matrix.postShear(openvdb::math::X_AXIS, openvdb::math::Z_AXIS, 0.25);
    matrix *= openvdb::math::rotation<Mat4d>(Vec3d(1, -2, 3).unit(), angle);
    matrix.postTranslate(Vec3d(12.1, -7.3, 100.7));
    return matrix;
}

const Mat4d kStraight = placed(Vec3d(0.3, 0.7, 1.9), 0), kTurned = placed(Vec3d(0.3, 0.7, 1.9), 2.4),
            kMirrored = placed(Vec3d(0.3, 0.7, -1.9), 2.4), kHalfTurn = placed(Vec3d(0.3, 0.7, 1.9), kPi),
            kSheared = placed(Vec3d(0.3, 0.7, 1.9), 2.4, true);

const char* const kEndings[] = {"a.mha", "a.nrrd", "a.nii", "a.NII.GZ", "folder", "other.d/"};

std::string contentsOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

class DenseFiles : public Import {
  protected:
    /// Writes the grid and reads it again.
    ImportedVolume again(const FloatGrid::Ptr& grid, const std::string& name) {
        DenseSource source(grid);
        writeDense(folder / name, source);
        return importVolume({folder / name}, {});
    }

    /// Imported voxels count from 0.
    void expectSame(const FloatGrid& grid, const ImportedVolume& volume, double tolerance) {
        ASSERT_TRUE(volume.grid);
        EXPECT_EQ(volume.dims, Index3(20, 5, 12));
        EXPECT_EQ(volume.type, SampleType::float32);
        EXPECT_TRUE(volume.notes.empty()) << volume.notes.front();
        for (auto at = openvdb::CoordBBox(kCorner, kLast).begin(); at; ++at) {
            const float one = grid.tree().getValue(*at), other = volume.grid->tree().getValue(*at - kCorner);
            EXPECT_EQ(std::memcmp(&one, &other, sizeof one), 0) << *at << ": " << one << " became " << other;
        }
        for (const Coord& at : {kCorner, kLast, Coord(kCorner.x(), kLast.y(), kCorner.z())})
            EXPECT_LT((grid.indexToWorld(at) - volume.grid->indexToWorld(at - kCorner)).length(), tolerance) << at;
    }

    std::string errorOf(const FloatGrid::Ptr& grid, const std::string& name, const DenseChoice& choice = {}) {
        try {
            DenseSource source(grid, choice);
            writeDense(folder / name, source);
        } catch (const Error& e) {
            return e.what();
        }
        return "no error";
    }
};

/// Places are up to 147 units from 0, where neighbouring floats are 7.6e-6 apart (found: 3.86e-6), and doubles 1.4e-14;
/// a sum of four has some roundings (found: 3.18e-14).
double toleranceOf(const std::string& name) {
    return denseFormat(name) == DenseFormat::nifti ? 4.2e-6 : 3.5e-14;
}

}  // namespace

TEST_F(DenseFiles, ComeBackToTheBitWhereTheyWere) {
    for (const Mat4d& matrix : {kStraight, kTurned, kMirrored, kHalfTurn})
        for (const std::string name : kEndings) {
            SCOPED_TRACE(name);
            const FloatGrid::Ptr grid = labelled(matrix);
            expectSame(*grid, again(grid, name), toleranceOf(name));
        }
}

TEST_F(DenseFiles, KeepShearedAxesOrRefuseThem) {
    const FloatGrid::Ptr grid = labelled(kSheared);
    for (const std::string name : {"a.nrrd", "a.nii", "folder"}) {
        SCOPED_TRACE(name);
        expectSame(*grid, again(grid, name), toleranceOf(name));
    }
    EXPECT_NE(errorOf(grid, "a.mha").find("sheared"), std::string::npos) << errorOf(grid, "a.mha");
    EXPECT_FALSE(fs::exists(folder / "a.mha"));
}

TEST_F(DenseFiles, NiftisQformIsThePlaceOfItsSform) {
    constexpr std::size_t kSformCode = 254;
    for (const Mat4d& matrix : {kStraight, kTurned, kMirrored, kHalfTurn}) {
        const FloatGrid::Ptr grid = labelled(matrix);
        again(grid, "a.nii");
        std::string bytes = contentsOf(folder / "a.nii");
        poke(bytes, kSformCode, std::int16_t(0));
        writeFile(folder / "q.nii", bytes);
        // What the origin's floats leave, as of the sform; a quaternion's add little (found: 3.7e-6).
        expectSame(*grid, importVolume({folder / "q.nii"}, {}), 4e-6);
    }
}

TEST_F(DenseFiles, ValuesOutsideOfActiveVoxelsAreTheirOwn) {
    const FloatGrid::Ptr grid = labelled(kStraight, 2.5f);
    grid->tree().addTile(1, Coord(0, 0, 16), 7.5f, true);
    const Coord high(40, 9, 24);
    DenseSource source(grid, {IndexBox{Index3(-3, 5, 13), Index3(40, 9, 24)}, {}});
    writeDense(folder / "a.nrrd", source);
    const ImportedVolume volume = importVolume({folder / "a.nrrd"}, {});
    for (auto at = openvdb::CoordBBox(kCorner, high).begin(); at; ++at)
        EXPECT_EQ(volume.grid->tree().getValue(*at - kCorner), grid->tree().getValue(*at)) << *at;
}

TEST_F(DenseFiles, SlicesKnowTheirPlaceOneByOne) {
    const FloatGrid::Ptr grid = labelled(kTurned);
    again(grid, "folder");
    EXPECT_TRUE(fs::exists(folder / "folder/slice_0000.tif"));
    const ImportedVolume part = importVolume({folder / "folder/slice_0004.tif", folder / "folder/slice_0005.tif"}, {});
    EXPECT_LT((part.grid->indexToWorld(Coord(0)) - grid->indexToWorld(kCorner + Coord(0, 0, 4))).length(),
              toleranceOf("folder"));
    EXPECT_LT((part.grid->indexToWorld(Coord(0, 0, 1)) - grid->indexToWorld(kCorner + Coord(0, 0, 5))).length(),
              toleranceOf("folder"));
    std::string slice = contentsOf(folder / "folder/slice_0004.tif");
    slice[slice.find("raysweep_place=") + 15] = '?';
    writeFile(folder / "damaged.tif", slice);
    expectError({folder / "damaged.tif"}, "raysweep_place");
}

TEST_F(DenseFiles, APackedFileUnpacksToThePlainOne) {
    const FloatGrid::Ptr grid = labelled(kStraight);
    again(grid, "a.nii");
    again(grid, "a.nii.gz");
    const std::string plain = contentsOf(folder / "a.nii");
    std::string unpacked(plain.size() + 1, '\0');
    const gzFile file = gzopen((folder / "a.nii.gz").c_str(), "rb");
    EXPECT_EQ(gzread(file, unpacked.data(), unsigned(unpacked.size())), int(plain.size()));
    EXPECT_FALSE(gzdirect(file)) << "not packed at all";
    gzclose(file);
    unpacked.pop_back();
    EXPECT_EQ(unpacked, plain);
}

TEST_F(DenseFiles, OneNumberPerVoxelIsChosenFromColours) {
    const auto colours = openvdb::Vec3SGrid::create();
    colours->setName("Cd");
    colours->tree().setValue(Coord(1, 2, 3), openvdb::Vec3s(0.25f, 0.5f, 0.75f));
    expectError<InvalidArgument>([&] { DenseSource source(colours); }, "'Cd' holds 3 channels");
    expectError<InvalidArgument>([&] { DenseSource source(colours, {{}, 3}); }, "channel 3");
    DenseSource source(colours, {{}, 1});
    EXPECT_EQ(*source.slice(0), 0.5f);
    expectError<InvalidArgument>([&] { DenseSource none(labelled(kStraight), {{}, 1}); }, "channel 1");
}

TEST_F(DenseFiles, WhatCannotBeWrittenIsSaidAndNothingIsLeft) {
    const auto expect = [&](const FloatGrid::Ptr& grid, const std::string& name, const std::string& part,
                            const DenseChoice& choice = {}) {
        const std::string error = errorOf(grid, name, choice);
        EXPECT_NE(error.find(part), std::string::npos) << error << "\n  lacks: " << part;
        EXPECT_TRUE(folder.isEmpty()) << name;
    };
    const FloatGrid::Ptr grid = labelled(kStraight);
    expect(FloatGrid::create(), "a.mha", "no active voxels");
    expect(grid, "a.xyz", "its ending is not known");
    expect(grid, "a.mha", "denseBox: 4 to 3 along j", {IndexBox{Index3(0, 4, 0), Index3(9, 3, 9)}, {}});
    expect(grid, "a.nii", "no more than 32767", {IndexBox{Index3(0), Index3(32767, 0, 0)}, {}});
    expect(grid, "a.nrrd", "GB are free there", {IndexBox{Index3(0), Index3(999, 999, 500000000)}, {}});
    expect(grid, "a.nrrd", "eight slices of 500000001x500000001 need", {IndexBox{Index3(0), Index3(500000000)}, {}});
    Mat4d far = Mat4d::identity();
    far.postScale(Vec3d(0.001));
    far.postTranslate(Vec3d(12345.678));
    expect(labelled(far), "a.nii", "single precision would move voxels");
    for (const std::string name : {"a.mha", "a.nii.gz", "folder"}) {
        const FloatGrid::Ptr bad = labelled(kStraight);
        bad->tree().setValue(Coord(2, 6, 20), std::numeric_limits<float>::quiet_NaN());
        expect(bad, name, "NaN or infinite at voxel (2, 6, 20)");
    }
}

TEST_F(DenseFiles, AFolderIsReplacedIfItHoldsNothingElse) {
    const FloatGrid::Ptr grid = labelled(kStraight);
    again(grid, "folder");
    DenseSource thin(grid, {IndexBox{Index3(0, 5, 13), Index3(3, 9, 14)}, {}});
    writeDense(folder / "folder", thin);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder / "folder"), {}), 2);
    for (const std::string name : {"slice_12.png", "slice_.tif", "slice_0001.tif.txt", "notes"}) {
        writeFile(folder / ("folder/" + name), "x");
        expectError<IoError>([&] { writeDense(folder / "folder", thin); }, name);
        expectError<IoError>([&] { requireDenseOutput(folder / "folder"); }, name);
        fs::remove(folder / ("folder/" + name));
    }
    EXPECT_NO_THROW(requireDenseOutput(folder / "folder"));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1) << "something was left behind";
}

TEST_F(DenseFiles, TheEndingSaysTheFormat) {
    fs::create_directory(folder / "scan.2024");
    fs::create_directory(folder / "scan.vdb");
    const std::pair<std::string, DenseFormat> kExpected[] = {
        {"a.mha", DenseFormat::metaImage},      {"A.MHA", DenseFormat::metaImage},   {"a.nrrd", DenseFormat::nrrd},
        {"a.nii", DenseFormat::nifti},          {"a.b.nii.gz", DenseFormat::nifti},  {"a.gz", DenseFormat::unknown},
        {"a.vdb", DenseFormat::unknown},        {"a.tif", DenseFormat::unknown},     {"a.nhdr", DenseFormat::unknown},
        {"a", DenseFormat::tiffFolder},         {"a.tif/", DenseFormat::tiffFolder}, {"./", DenseFormat::tiffFolder},
        {"scan.2024", DenseFormat::tiffFolder}, {"scan.2025", DenseFormat::unknown}, {"scan.vdb", DenseFormat::unknown},
        {"nii.gz", DenseFormat::unknown},
    };
    for (const auto& [name, format] : kExpected) EXPECT_EQ(denseFormat(folder / name), format) << name;
}
