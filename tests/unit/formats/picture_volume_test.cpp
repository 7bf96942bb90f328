// Pictures as numbers: what TIFF's fields, ImageJ's descriptions, OME-XML and others mean, written by hand.
#include <cmath>
#include <cstring>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>

#include "raysweep/image/image_io.h"
#include "support/expect_error.h"
#include "unit/formats/import_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

/// Rows of samples packed into `bits` bits each, the highest first, whole bytes a row.
std::string packedRows(const std::vector<std::uint32_t>& samples, int width, int bits) {
    std::string bytes;
    for (std::size_t row = 0; row < samples.size(); row += std::size_t(width)) {
        std::string row8((std::size_t(width * bits) + 7) / 8, '\0');
        for (int n = 0; n < width * bits; ++n)
            if (samples[row + std::size_t(n / bits)] >> (bits - 1 - n % bits) & 1)
                row8[std::size_t(n / 8)] = char(row8[std::size_t(n / 8)] | 0x80 >> n % 8);
        bytes += row8;
    }
    return bytes;
}

class Pictures : public Import {
  protected:
    std::string file(const std::string& bytes, const std::string& name = "a.tif") {
        writeFile(folder / name, bytes);
        return folder / name;
    }
    std::string page(std::vector<TiffField> fields, const std::string& data) {
        return file(tiffBytes({{fields, data}}));
    }

    /// Pages 3x4 of `label(i, j, page)`, the first with `description`.
    std::string stack(int pages, const std::string& description) {
        std::vector<TiffPage> all;
        for (int k = 0; k < pages; ++k) {
            std::vector<std::uint16_t> samples;
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 3; ++i) samples.push_back(std::uint16_t(label(i, j, k)));
            all.push_back({tiffFields(3, 4, 16), bytesOf(samples)});
        }
        if (!description.empty()) all[0].fields.push_back(tiffDescription(description));
        return file(tiffBytes(all));
    }
};

ImportOptions asStored() {
    ImportOptions options;
    options.normalization = Normalization::none;
    return options;
}

void expectValues(const ImportedVolume& volume, const std::vector<double>& values) {
    ASSERT_EQ(volume.dims.x * volume.dims.y * volume.dims.z, int(values.size()));
    for (int n = 0; n < int(values.size()); ++n)
        EXPECT_FLOAT_EQ(volume.grid->tree().getValue(Coord(n % volume.dims.x, n / volume.dims.x % volume.dims.y,
                                                           n / volume.dims.x / volume.dims.y)),
                        float(values[std::size_t(n)]))
            << n;
}

}  // namespace

TEST_F(Pictures, TiffOfAnyNumberOfBitsHasTheNumbersStored) {
    for (const int bits : {1, 2, 4, 6, 8, 10, 12, 14, 16, 24, 32}) {
        for (const int photometric : {0, 1}) {  // small numbers are white, or black: the numbers are the same
            SCOPED_TRACE(std::to_string(bits) + " bits, photometric " + std::to_string(photometric));
            const double highest = std::exp2(bits) - 1;
            std::vector<std::uint32_t> samples;
            std::vector<double> stored, normalised;
            for (int n = 0; n < 6; ++n) {
                const double value = n == 5 ? highest : std::min(highest, double(n % 2 ? 1 + n : 0));
                samples.push_back(std::uint32_t(value));
                stored.push_back(value);
                normalised.push_back(value / highest);
            }
            std::string data = packedRows(samples, 3, bits);
            if (bits == 16) data = bytesOf(std::vector<std::uint16_t>(samples.begin(), samples.end()));
            if (bits == 24) {
                data.clear();
                for (const std::uint32_t sample : samples)
                    data += {char(sample), char(sample >> 8), char(sample >> 16)};
            }
            if (bits == 32) data = bytesOf(samples);
            const std::string path = page(tiffFields(3, 2, bits, photometric), data);
            expectValues(importVolume({path}, asStored()), stored);
            expectValues(importVolume({path}, {}), normalised);
        }
    }
    // Where BitsPerSample is missing it is 1.
    std::vector<TiffField> fields = tiffFields(16, 1, 1);
    fields.erase(fields.begin() + 2);
    expectValues(importVolume({page(fields, "\x0f\x55")}, {}), {0, 0, 0, 0, 1, 1, 1, 1, 0, 1, 0, 1, 0, 1, 0, 1});
}

TEST_F(Pictures, TiffOfOtherTypes) {
    expectValues(importVolume({page(tiffFields(2, 1, 16, 1, 2), bytesOf(std::vector<std::int16_t>{-5, 300}))}, {}),
                 {-5, 300});
    expectValues(importVolume({page(tiffFields(2, 1, 64, 1, 3), bytesOf(std::vector<double>{-0.5, 2}))}, {}),
                 {-0.5, 2});
    expectValues(
        importVolume({page(tiffFields(2, 1, 16, 1, 3), bytesOf(std::vector<std::uint16_t>{0xb800, 0x4000}))}, {}),
        {-0.5, 2});  // half floats
    expectError({page(tiffFields(2, 1, 24, 1, 3), "abcdef")}, "floats of 24 bits");
    expectError({page(tiffFields(2, 1, 64, 1, 6), std::string(16, 'x'))}, "complex numbers");
    std::vector<TiffField> palette = tiffFields(2, 1, 8, 3);
    palette.emplace_back(320, 3, 768, std::string(2 * 768, 'x'));
    expectError({page(palette, "ab")}, "places in a palette of colours");
    expectError({page(tiffFields(2, 1, 8, 5), "ab")}, "neither grey nor RGB");
}

TEST_F(Pictures, TiffIsTurnedAsItSays) {
    const auto turned = [&](int orientation) {
        std::vector<TiffField> fields = tiffFields(2, 2, 8);
        fields.emplace_back(274, std::uint32_t(orientation));
        return page(fields, "\1\2\3\4");
    };
    expectValues(importVolume({turned(1)}, asStored()), {1, 2, 3, 4});
    expectValues(importVolume({turned(2)}, asStored()), {2, 1, 4, 3});
    expectValues(importVolume({turned(3)}, asStored()), {4, 3, 2, 1});
    expectValues(importVolume({turned(4)}, asStored()), {3, 4, 1, 2});
    expectError({turned(6)}, "Orientation 6");
}

TEST_F(Pictures, SmallerCopiesAndMasksAreNoSlices) {
    std::vector<TiffPage> pages(3, {tiffFields(2, 1, 8), "\1\2"});
    pages[0].fields = tiffFields(1, 1, 8);
    pages[0].fields.emplace_back(254, 1u);  // reduced
    pages[2].fields.emplace_back(254, 4u);  // mask
    expectValues(importVolume({file(tiffBytes(pages))}, asStored()), {1, 2});
}

TEST_F(Pictures, ChannelsArePickedFromColours) {
    std::vector<TiffField> fields = tiffFields(2, 1, 8, 2);
    fields[5] = TiffField(277, 3u);
    fields[2] = TiffField(258, 3, 3, std::string("\10\0\10\0\10\0", 6));
    fields[7] = TiffField(339, 3, 3, std::string("\1\0\1\0\1\0", 6));
    const std::string path = page(fields, "\1\2\3\4\5\6");
    expectError({path},
                "holds 3 channels, but a volume needs one number per voxel; choose one by `channel`: 0 red, 1 green");
    ImportOptions options = asStored();
    for (int c = 0; c < 3; ++c) {
        options.channel = c;
        expectValues(importVolume({path}, options), {1.0 + c, 4.0 + c});
    }
    options.channel = 3;
    expectError({path}, "channel 3: ", options);
}

TEST_F(Pictures, AStackOfImageJMayHaveOneDirectoryOnly) {
    const std::string samples = bytesOf(labels<std::uint16_t>(kDims));
    const std::string description = "ImageJ=1.53t\nimages=5\nslices=5\nunit=um\nspacing=2.5\n";
    std::vector<TiffField> fields = tiffFields(3, 4, 16);
    fields.push_back(tiffDescription(description));
    fields.emplace_back(282, 5, 1, std::string("\2\0\0\0\1\0\0\0", 8));  // two columns in a micrometre
    const ImportedVolume volume = importVolume({page(fields, samples)}, {});
    expectLabels(volume, kDims, 1 / 65535.0);
    expectAt(volume, Coord(1, 1, 1), Vec3(0.5, 1, 2.5));
    EXPECT_EQ(volume.unit, "um");
    fields[8] = tiffDescription("ImageJ=1.53t\nimages=50\nslices=50\n");
    expectError({page(fields, samples)}, "promises 50 images, but there is one, and no room");
    fields[3] = TiffField(259, 5u);
    expectError({page(fields, samples)}, "promises 50 images");
}

TEST_F(Pictures, HyperstacksAreListedAndChosenFrom) {
    const std::string imageJ = "ImageJ=1.53t\nimages=12\nchannels=2\nslices=3\nframes=2\nhyperstack=true\n";
    const std::string ome =
        "<?xml version=\"1.0\"?><OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeX=\"3\" SizeY=\"4\" "
        "SizeZ=\"3\" SizeC=\"2\" SizeT=\"2\" PhysicalSizeX=\"0.5\" PhysicalSizeY=\"0.5\" "
        "PhysicalSizeZ=\"2\"><Channel Name=\"DAPI\"/><Channel Name=\"GFP\"/></Pixels></Image></OME>";
    for (const bool byOme : {false, true}) {
        const std::string path = stack(12, byOme ? ome : imageJ);
        expectError({path}, "holds 2 volumes (frames)");
        ImportOptions options = asStored();
        options.volumeIndex = 1;
        expectError({path}, byOme ? "choose one by `channel`: 0 DAPI, 1 GFP" : "choose one by `channel`: 0 to 1",
                    options);
        for (int channel = 0; channel < 2; ++channel)
            for (int frame = 0; frame < 2; ++frame) {
                options.channel = channel, options.volumeIndex = frame;
                const ImportedVolume volume = importVolume({path}, options);
                EXPECT_EQ(volume.dims, Index3(3, 4, 3));
                for (int k = 0; k < 3; ++k) {
                    const int page = byOme ? k + 3 * channel + 6 * frame : channel + 2 * k + 6 * frame;
                    EXPECT_EQ(volume.grid->tree().getValue(Coord(2, 1, k)), label(2, 1, page));
                }
                if (byOme) expectAt(volume, Coord(1, 1, 1), Vec3(0.5, 0.5, 2));
            }
    }
    expectError({stack(11, imageJ)}, "has 11 pages, but ImageJ promises 2 channels x 3 slices x 2 frames");
    expectError({stack(2, "ImageJ=1.53t\nimages=2\nchannels=1000000\nframes=1000000\n")},
                "more pages than there can be");
}

// Their product fits no int.
TEST_F(Pictures, SizesOfOmeXmlAreHeldAgainstWhatThereCanBeBeforePagesAreCounted) {
    const std::string sizes =
        "<OME><Image><Pixels DimensionOrder=\"XYCZT\" SizeC=\"1048576\" SizeZ=\"1048576\" SizeT=\"2\">";
    const std::string last = "<TiffData IFD=\"1\" FirstC=\"1048575\" FirstZ=\"1048575\" FirstT=\"1\"/>";
    const std::string end = "</Pixels></Image></OME>";
    expectError({stack(2, sizes + last + end)}, "OME-XML promises more pages than there can be");
    const std::string few = "<OME><Image><Pixels DimensionOrder=\"XYCZT\" SizeC=\"1\" SizeZ=\"2\" SizeT=\"1\">";
    expectError({stack(2, few + "<TiffData IFD=\"1\" FirstZ=\"2147483647\" FirstC=\"2147483647\"/>" + end)},
                "in an order of their own");
    expectLabels(importVolume({stack(2, few + "<TiffData IFD=\"1\" FirstZ=\"1\"/>" + end)}, asStored()),
                 Index3(3, 4, 2));
}

TEST_F(Pictures, ImageJsCalibrationIsApplied) {
    const auto straight = importVolume({stack(2, "ImageJ=1.53t\nimages=2\nslices=2\ncf=0\nc0=-32768\nc1=1\n")}, {});
    EXPECT_EQ(straight.grid->tree().getValue(Coord(2, 3, 1)), label(2, 3, 1) - 32768);
    expectError({stack(2, "ImageJ=1.53t\nimages=2\nslices=2\ncf=3\nc0=1\nc1=2\n")}, "no straight line");
}

TEST_F(Pictures, GreyOfFewerBitsInOtherFormats) {
    expectValues(importVolume({file("P5\n4 1\n100\n\1\12\62\144", "a.pgm")}, asStored()), {1, 10, 50, 100});
    expectValues(importVolume({file("P5\n4 1\n100\n\1\12\62\144", "a.pgm")}, {}), {0.01, 0.1, 0.5, 1});
    std::string wide("P5\n# 12 bits\n3 1\n4095\n");
    wide += std::string("\3\350\17\377\0\1", 6);
    expectValues(importVolume({file(wide, "b.pgm")}, asStored()), {1000, 4095, 1});
}

TEST_F(Pictures, HeadersMayNotPromiseMoreThanTheirFilesCanHold) {
    expectError({page(tiffFields(60000, 60000, 8), "few")}, "more pixels than a file of its size can hold");
    expectError({page(tiffFields(2000000, 2, 8), "few")}, "it is damaged");
}

// Libraries take memory for a tile, or for a row of pixels, as large as these say they are: 4 GB for 200 bytes.
TEST_F(Pictures, TilesAndRowsMayNotBeLargerThanTheirFilesCanHold) {
    std::vector<TiffField> fields = tiffFields(16, 16, 8);
    for (const std::uint16_t tag : {322, 323}) fields.emplace_back(tag, 65536u);
    fields.emplace_back(324, 8u);
    fields.emplace_back(325, 4u);
    const std::string tiled = page(fields, "tile");
    expectError({tiled}, "more pixels than a file of its size can hold");
    test::expectError<IoError>([&] { readImage(tiled); }, "more pixels than a file of its size can hold");
    fields = tiffFields(60000, 1, 8);
    fields[5] = TiffField(277, 65535u);
    ImportOptions options;
    options.channel = 0;
    expectError({page(fields, "row")}, "more pixels than a file of its size can hold", options);
}

TEST_F(Pictures, ChannelsAndPartsOfAnExrAreListedAndChosen) {
    const Imath::Box2i window({2, 5}, {4, 6});
    std::vector<Imf::Header> headers(2, Imf::Header({{0, 0}, {9, 9}}, window));
    std::vector<float> values(24);
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = float(n) + 1;
    for (std::size_t n = 0; n < 2; ++n) {
        headers[n].setName(n == 0 ? "left" : "right");
        headers[n].setType(Imf::SCANLINEIMAGE);
        headers[n].channels().insert("heat", Imf::Channel(Imf::FLOAT));
        headers[n].channels().insert("soot", Imf::Channel(Imf::FLOAT));
    }
    {
        Imf::MultiPartOutputFile out((folder / "a.exr").c_str(), headers.data(), 2);
        for (int n = 0; n < 2; ++n) {
            Imf::OutputPart part(out, n);
            Imf::FrameBuffer frame;
            frame.insert("heat", Imf::Slice::Make(Imf::FLOAT, values.data() + 12 * n, window, 4, 12));
            frame.insert("soot", Imf::Slice::Make(Imf::FLOAT, values.data() + 12 * n + 6, window, 4, 12));
            part.setFrameBuffer(frame);
            part.writePixels(2);
        }
    }
    const std::string path = folder / "a.exr";
    expectError({path}, "holds 2 parts, and one is wanted; choose one by `volumeIndex`: 0 left, 1 right");
    ImportOptions options;
    options.volumeIndex = 1;
    expectError({path}, "choose one by `channel`: 0 heat, 1 soot", options);
    options.channel = 1;
    const ImportedVolume volume = importVolume({path}, options);
    expectValues(volume, {19, 20, 21, 22, 23, 24});
    expectAt(volume, Coord(0, 0, 0), Vec3(2, 5, 0));
}
