// What NIfTI's fields mean, by nifti1.h and nifti2.h; and headers that are not to be trusted.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "unit/formats/import_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

constexpr std::size_t kDim = 40, kDatatype = 70, kBitpix = 72, kPixdim = 76, kOffset = 108, kSlope = 112, kInter = 116,
                      kUnits = 123, kQformCode = 252, kSformCode = 254, kQuaternion = 256, kQoffset = 268;

class Nifti : public Import {
  protected:
    std::string plain = niftiBytes({{3, 4, 5}, labels<std::int16_t>(kDims)});

    std::string file(const std::string& bytes, const std::string& name = "a.nii") {
        writeFile(folder / name, bytes);
        return folder / name;
    }
    /// The header of `plain` with another type of voxels.
    std::string changedHeader(int datatype, int bitpix) const {
        std::string bytes = plain.substr(0, 352);
        poke(bytes, kDatatype, std::int16_t(datatype));
        poke(bytes, kBitpix, std::int16_t(bitpix));
        return bytes;
    }
    /// `plain` changed.
    template <class Change>
    std::string changed(const Change& change) {
        std::string bytes = plain;
        change(bytes);
        return file(bytes);
    }
};

/// The same volume as NIfTI-2.
std::string version2(const std::string& one) {
    std::string two(544, '\0');
    poke(two, 0, std::int32_t(540));
    two.replace(4, 8, "n+2\0\r\n\032\n", 8);
    const auto number = [&](std::size_t at) {
        float value;
        std::memcpy(&value, one.data() + at, 4);
        return double(value);
    };
    two.replace(12, 4, one.substr(kDatatype, 4));
    for (std::size_t n = 0; n < 8; ++n) {
        std::int16_t size;
        std::memcpy(&size, one.data() + kDim + 2 * n, 2);
        poke(two, 16 + 8 * n, std::int64_t(size));
        poke(two, 104 + 8 * n, number(kPixdim + 4 * n));
    }
    poke(two, 168, std::int64_t(544));
    poke(two, 176, number(kSlope));
    poke(two, 184, number(kInter));
    poke(two, 348, std::int32_t(1));
    for (std::size_t n = 0; n < 12; ++n) poke(two, 400 + 8 * n, number(280 + 4 * n));
    poke(two, 500, std::int32_t(2));
    return two + one.substr(352);
}

}  // namespace

TEST_F(Nifti, ASlopeOf0MeansNoScalingWhateverTheIntercept) {
    for (const float slope : {0.0f, std::numeric_limits<float>::quiet_NaN()})
        expectLabels(importVolume({changed([&](auto& b) { poke(b, kSlope, slope), poke(b, kInter, 5.0f); })}, {}),
                     kDims);
    const auto volume = importVolume({changed([](auto& b) { poke(b, kSlope, -2.0f), poke(b, kInter, 5.5f); })}, {});
    EXPECT_EQ(volume.grid->tree().getValue(Coord(2, 3, 4)), 5.5f - 2 * label(2, 3, 4));
    expectError({changed([](auto& b) { poke(b, kSlope, 1.0f), poke(b, kInter, INFINITY); })}, "not finite");
}

TEST_F(Nifti, NumbersThatTheFileRescalesStayAsTheyAre) {
    for (const float slope : {1.0f, 100.0f, 200.0f}) {  // what 200 makes fits 16 bits without a sign
        std::string bytes = changedHeader(2, 8);
        poke(bytes, kSlope, slope);
        bytes += std::string(60, '\1');
        const float one = slope == 1 ? 1 / 255.0f : slope;
        EXPECT_FLOAT_EQ(importVolume({file(bytes)}, {}).grid->tree().getValue(Coord(1, 1, 1)), one) << slope;
    }
}

TEST_F(Nifti, ShearedVolumesKeepTheirPlace) {
    NiftiImage image{{3, 4, 5}, labels<std::int16_t>(kDims)};
    const float rows[3][4] = {{2, 0.5f, 0, 1}, {0, 3, 0, 2}, {0, 0, 4, 3}};
    std::memcpy(image.rows, rows, sizeof rows);
    const ImportedVolume volume = importVolume({file(niftiBytes(image))}, {});
    expectLabels(volume, kDims);
    expectAt(volume, Coord(0, 0, 0), Vec3(-1, -2, 3));
    expectAt(volume, Coord(1, 2, 1), Vec3(-4, -8, 7));
}

TEST_F(Nifti, TheQformIsAQuaternion) {
    // A third of a turn about (1,1,1): i runs along y, j along z, k along x; qfac -1 turns k around.
    for (const float qfac : {1.0f, -1.0f, 0.0f}) {
        const auto volume = importVolume({changed([&](auto& b) {
                                             poke(b, kSformCode, std::int16_t(0)), poke(b, kQformCode, std::int16_t(1));
                                             for (std::size_t n = 0; n < 3; ++n)
                                                 poke(b, kQuaternion + 4 * n, 0.5f),
                                                     poke(b, kQoffset + 4 * n, float(5 + n)),
                                                     poke(b, kPixdim + 4 + 4 * n, float(2 + n));
                                             poke(b, kPixdim, qfac);
                                         })},
                                         {});
        expectAt(volume, Coord(0, 0, 0), Vec3(-5, -6, 7));
        expectAt(volume, Coord(1, 0, 0), Vec3(-5, -8, 7));
        expectAt(volume, Coord(0, 1, 0), Vec3(-5, -6, 10));
        expectAt(volume, Coord(0, 0, 1), Vec3(qfac < 0 ? -1 : -9, -6, 7));
    }
}

TEST_F(Nifti, TheSformCountsBeforeTheQformAndDifferencesAreSaid) {
    const auto both = [&](float shift) {
        return importVolume({changed([&](auto& b) { poke(b, kQformCode, std::int16_t(1)), poke(b, kQoffset, shift); })},
                            {});
    };
    EXPECT_TRUE(both(0).notes.empty());
    const ImportedVolume differing = both(7);
    expectAt(differing, Coord(0, 0, 0), Vec3(0, 0, 0));
    ASSERT_EQ(differing.notes.size(), 1u);
    EXPECT_NE(differing.notes[0].find("that of the sform was taken"), std::string::npos);
}

TEST_F(Nifti, UnitsBecomeMillimetres) {
    const struct {
        int unit;
        double factor;
    } units[] = {{0, 1}, {1, 1000}, {2, 1}, {3, 1e-3}, {8 + 3, 1e-3}};  // 8: seconds along the fourth axis
    for (const auto& [unit, factor] : units)
        expectAt(importVolume({changed([u = unit](auto& b) { poke(b, kUnits, std::uint8_t(u)); })}, {}), Coord(1, 2, 3),
                 Vec3(-1, -2, 3) * factor);
}

TEST_F(Nifti, VersionTwoAndPairsOfFilesAndBothByteOrders) {
    expectLabels(importVolume({file(version2(plain))}, {}), kDims);
    std::string header = plain.substr(0, 348);
    header.replace(344, 4, std::string("ni1\0", 4));
    poke(header, kOffset, 0.0f);
    file(header, "pair.hdr");
    file(plain.substr(352), "pair.img");
    expectLabels(importVolume({folder / "pair.hdr"}, {}), kDims);
    expectLabels(importVolume({folder / "pair.img"}, {}), kDims);
    file(plain.substr(352) + "more", "pair.img");
    expectError({folder / "pair.hdr"}, "its data go on behind");
    std::filesystem::remove(folder / "pair.img");
    expectError({folder / "pair.hdr"}, "there is no '");

    std::string swapped = plain;  // byte by byte, field by field
    const auto swap = [&](std::size_t at, std::size_t size) { std::reverse(&swapped[at], &swapped[at] + size); };
    swap(0, 4);
    for (std::size_t n = 0; n < 8; ++n) swap(kDim + 2 * n, 2), swap(kPixdim + 4 * n, 4);
    swap(kDatatype, 2), swap(kBitpix, 2), swap(kOffset, 4), swap(kSlope, 4), swap(kInter, 4);
    swap(kQformCode, 2), swap(kSformCode, 2);
    for (std::size_t n = 0; n < 12; ++n) swap(280 + 4 * n, 4);
    for (std::size_t at = 352; at < swapped.size(); at += 2) swap(at, 2);
    expectLabels(importVolume({file(swapped)}, {}), kDims);
}

TEST_F(Nifti, ChannelsAndVolumesAreListedAndChosen) {
    NiftiImage image{{3, 4, 5, 2}, labels<std::int16_t>(Index3(3, 4, 10))};
    const std::string instants = file(niftiBytes(image));
    expectError({instants}, "holds 2 volumes of 3x4x5, and one is wanted; choose one by `volumeIndex`: 0 to 1");
    ImportOptions options;
    options.volumeIndex = 1;
    EXPECT_EQ(importVolume({instants}, options).grid->tree().getValue(Coord(1, 2, 3)), label(1, 2, 8));
    options.volumeIndex = 2;
    expectError({instants}, "volumeIndex 2: ", options);

    options = ImportOptions();
    image.dims = {3, 4, 5, 1, 2};  // the fifth axis is of vectors
    const std::string vectors = file(niftiBytes(image));
    expectError({vectors}, "holds 2 channels");
    options.channel = 1;
    EXPECT_EQ(importVolume({vectors}, options).grid->tree().getValue(Coord(1, 2, 3)), label(1, 2, 8));

    std::string colours;
    for (int n = 0; n < 60; ++n) colours += {char(n), char(n + 60), char(n + 120)};
    const std::string rgb = file(changedHeader(128, 24) + colours);
    expectError({rgb}, "0 red, 1 green, 2 blue");
    options.channel = 2;
    options.normalization = Normalization::none;
    EXPECT_EQ(importVolume({rgb}, options).grid->tree().getValue(Coord(1, 0, 0)), 121);
}

TEST_F(Nifti, HeadersThatAreNotToBeTrustedAreRefusedAtOnce) {
    const auto refuse = [&](const std::string& part, const auto& change) { expectError({changed(change)}, part); };
    refuse("dim[0] is 8", [](auto& b) { poke(b, kDim, std::int16_t(8)); });
    refuse("dim[2] is -4", [](auto& b) { poke(b, kDim + 4, std::int16_t(-4)); });
    refuse("end too early", [](auto& b) { poke(b, kDim + 2, std::int16_t(32767)); });
    refuse("more samples than any file", [](auto& b) {
        poke(b, kDim, std::int16_t(7));
        for (std::size_t n = 1; n < 8; ++n) poke(b, kDim + 2 * n, std::int16_t(32767));
    });
    refuse("bitpix is 8", [](auto& b) { poke(b, kBitpix, std::int16_t(8)); });
    refuse("datatype 1536", [](auto& b) { poke(b, kDatatype, std::int16_t(1536)); });
    refuse("vox_offset", [](auto& b) { poke(b, kOffset, -1e30f); });
    refuse("vox_offset", [](auto& b) { poke(b, kOffset, std::numeric_limits<float>::quiet_NaN()); });
    refuse("sform is not finite", [](auto& b) { poke(b, 280, 1e30f); });
    refuse("Analyze 7.5", [](auto& b) { poke(b, 344, std::int32_t(0)); });
    refuse("span no volume", [](auto& b) { poke(b, 280, 0.0f); });
    expectError({file(plain.substr(0, 300))}, "not a NIfTI file");
    const auto bare =
        importVolume({changed([](auto& b) { poke(b, kSformCode, std::int16_t(0)), poke(b, kPixdim + 8, 0.0f); })}, {});
    expectAt(bare, Coord(1, 1, 1), Vec3(1, 1, 1));
    ASSERT_EQ(bare.notes.size(), 2u);
    EXPECT_NE(bare.notes[0].find("along j; 1 was taken"), std::string::npos);
    EXPECT_NE(bare.notes[1].find("which way it lies"), std::string::npos);
}
