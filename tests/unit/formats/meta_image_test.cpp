// What MetaImage's tags mean; and headers that are not to be trusted.
#include <filesystem>

#include <zlib.h>

#include "unit/formats/import_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

std::string zlibbed(const std::string& bytes) {
    std::string packed(compressBound(bytes.size()), '\0');
    uLongf size = packed.size();
    compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
             bytes.size());
    packed.resize(size);
    return packed;
}

class MetaImage : public Import {
  protected:
    std::vector<std::int16_t> numbers = labels<std::int16_t>(kDims);
    std::string bytes = bytesOf(numbers);

    /// 3x4x5 of int16 if not said otherwise.
    std::string meta(const std::string& tags, const std::string& data, const std::string& dataFile = "LOCAL",
                     const std::string& dims = "NDims = 3\nDimSize = 3 4 5\n") {
        writeFile(
            folder / "a.mha",
            "ObjectType = Image\n" + dims + "ElementType = MET_SHORT\n" + tags + "ElementDataFile = " + dataFile + "\n",
            data);
        return folder / "a.mha";
    }
};

}  // namespace

TEST_F(MetaImage, EveryWayToStoreSamplesGivesTheSame) {
    std::string text;
    for (const std::int16_t number : numbers) text += std::to_string(number) + " ";
    expectLabels(importVolume({meta("BinaryData = True\n", bytes)}, {}), kDims);
    expectLabels(importVolume({meta("BinaryData = False\n", text)}, {}), kDims);
    expectLabels(importVolume({meta("ElementByteOrderMSB = True\n", bytesOf(numbers, true))}, {}), kDims);
    expectLabels(importVolume({meta("CompressedData = True\n", zlibbed(bytes))}, {}), kDims);
    for (int k = 0; k < 5; ++k)
        writeFile(folder / ("s" + std::to_string(k) + ".raw"), bytes.substr(24 * std::size_t(k), 24));
    writeFile(folder / "all.raw", bytes);
    writeFile(folder / "head.raw", "head" + bytes);
    expectLabels(importVolume({meta("", "", "all.raw")}, {}), kDims);
    expectLabels(importVolume({meta("HeaderSize = -1\n", "", "head.raw")}, {}), kDims);
    expectLabels(importVolume({meta("HeaderSize = 4\n", "", "head.raw")}, {}), kDims);
    expectLabels(importVolume({meta("", "", "s%d.raw 0 4 1")}, {}), kDims);
    expectLabels(importVolume({meta("", "", "LIST\ns0.raw\ns1.raw\ns2.raw\ns3.raw\ns4.raw")}, {}), kDims);
}

TEST_F(MetaImage, PlacesAndIntensitiesAreThoseOfTheHeader) {
    struct Case {
        std::string tags;
        Vec3 first, last;  ///< of voxels (0,0,0) and (1,1,1)
    };
    const Case cases[] = {
        {"ElementSize = 1 2 3\nOrigin = 4 5 6\n", {4, 5, 6}, {5, 7, 9}},
        {"ElementSize = 9 9 9\nElementSpacing = 1 2 3\nPosition = 4 5 6\n", {4, 5, 6}, {5, 7, 9}},
        {"Rotation = 0 1 0 -1 0 0 0 0 1\nElementSpacing = 1 2 3\nAnatomicalOrientation = RAI\n", {0, 0, 0}, {-2, 1, 3}},
        {"TransformMatrix = 1 0 0 0.5 1 0 0 0 1\nCenterOfRotation = 0 0 0\n", {0, 0, 0}, {1.5, 1, 1}},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.tags);
        const ImportedVolume volume = importVolume({meta(c.tags, bytes)}, {});
        expectLabels(volume, kDims);
        expectAt(volume, Coord(0, 0, 0), c.first);
        expectAt(volume, Coord(1, 1, 1), c.last);
        EXPECT_EQ(volume.unit, "mm");
    }
    expectError({meta("TransformMatrix = 0 1 0 -1 0 0 0 0 1\nCenterOfRotation = 1 2 3\n", bytes)}, "CenterOfRotation");
    expectError({meta("Offset = 1 2 3\nPosition = 3 2 1\n", bytes)}, "say different things");
    const ImportedVolume volume = importVolume(
        {meta("ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1000\n", bytes)}, {});
    for (const Coord& at : {Coord(0, 0, 0), Coord(2, 3, 4)})
        EXPECT_EQ(volume.grid->tree().getValue(at), 2 * label(at.x(), at.y(), at.z()) - 1000);
}

// Whatever the slope, and whatever type the numbers then fit: it is not for that to say what is mapped to [0,1].
TEST_F(MetaImage, NumbersThatTheFileRescalesStayAsTheyAre) {
    const std::string header = "ObjectType = Image\nNDims = 3\nDimSize = 3 1 1\nElementType = MET_UCHAR\n";
    for (const int slope : {1, 2, 100, 200, 300}) {
        const std::string tag = "ElementToIntensityFunctionSlope = " + std::to_string(slope) + "\n";
        writeFile(folder / "a.mha", header + tag + "ElementDataFile = LOCAL\n", std::string("\0\1\377", 3));
        const ImportedVolume volume = importVolume({folder / "a.mha"}, {});
        const float unit = slope == 1 ? 1 / 255.0f : float(slope);
        EXPECT_FLOAT_EQ(volume.grid->tree().getValue(Coord(1, 0, 0)), unit) << slope;
        EXPECT_FLOAT_EQ(volume.grid->tree().getValue(Coord(2, 0, 0)), 255 * unit) << slope;
    }
}

TEST_F(MetaImage, ChannelsAndVolumesAreListedAndChosen) {
    std::vector<std::int16_t> samples;
    for (const std::int16_t number : numbers)
        for (int c = 0; c < 3; ++c) samples.push_back(std::int16_t(number + 1000 * c));
    const std::string channels = meta("ElementNumberOfChannels = 3\n", bytesOf(samples));
    expectError({channels},
                "holds 3 channels, but a volume needs one number per voxel; choose one by `channel`: 0 to 2");
    ImportOptions options;
    options.channel = 0;
    expectLabels(importVolume({channels}, options), kDims);
    options.channel = 2;
    EXPECT_EQ(importVolume({channels}, options).grid->tree().getValue(Coord(1, 2, 3)), label(1, 2, 3) + 2000);

    options.channel.reset();
    const std::string volumes =
        meta("Offset = 1 2 3 0\n", std::string(120, 'x') + bytes, "LOCAL", "NDims = 4\nDimSize = 3 4 5 2\n");
    expectError({volumes}, "holds 2 volumes of 3x4x5");
    options.volumeIndex = 1;
    const ImportedVolume second = importVolume({volumes}, options);
    expectLabels(second, kDims);
    expectAt(second, Coord(0, 0, 0), Vec3(1, 2, 3));
}

TEST_F(MetaImage, HeadersThatAreNotToBeTrustedAreRefusedAtOnce) {
    const auto refuse = [&](const std::string& path, const std::string& part) { expectError({path}, part); };
    refuse(meta("", "", "%s%n%d 1 100000000 1"), "must have one number such as %d");
    refuse(meta("", "", "%99999999d.raw 1 2 1"), "must have one number");
    refuse(meta("", "", "%d.raw 1 100000000 1"), "more than there can be");
    refuse(meta("", "", "a.mha"), "the file of its own data");
    refuse(meta("", bytes, "LOCAL", "NDims = 1e300\nDimSize = 3 4 5\n"), "NDims '1e300'");
    refuse(meta("", bytes, "LOCAL", "NDims = 3\nDimSize = 3 -4 5\n"), "each larger than 0");
    refuse(meta("", bytes, "LOCAL", "NDims = 3\nDimSize = 2000000000 2000000000 5\n"), "more samples than any file");
    refuse(meta("ElementNumberOfChannels = 2000000000\n", bytes), "choose one by");
    refuse(meta("ElementNumberOfChannels = -1\n", bytes), "ElementNumberOfChannels is -1");
    refuse(meta("HeaderSize = -2\n", bytes), "HeaderSize is negative");
    refuse(meta("HeaderSize = 9223372036854775807\n", bytes), "end too early");
    const std::string packed = zlibbed(bytes);
    refuse(meta("CompressedData = True\n", packed.substr(0, packed.size() / 2)), "end too early");
    refuse(meta("CompressedData = True\n", zlibbed(bytes), "LOCAL", "NDims = 3\nDimSize = 3000 4000 50\n"),
           "end too early");
    refuse(meta("ElementSpacing = 1 nan 1\n", bytes), "is not 3 finite numbers");
    refuse(meta("BinaryData = maybe\n", bytes), "neither True nor False");
    refuse(meta("DimSize = 3 4 5\n", bytes), "given twice");
    std::filesystem::create_symlink("/dev/zero", folder / "endless.mha");
    refuse(folder / "endless.mha", "a device or a pipe");
    std::filesystem::create_symlink("/dev/zero", folder / "endless.raw");
    refuse(meta("", "", "endless.raw"), "a device or a pipe");
    ImportOptions raw = rawOptions(kDims, SampleType::uint8);
    expectError({folder / "endless.raw"}, "a device or a pipe", raw);
}
