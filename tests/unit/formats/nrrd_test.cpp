// What NRRD's definition lets a header say, field by field; and headers that are not to be trusted.
#include <array>
#include <filesystem>

#include <zlib.h>

#include "unit/formats/import_fixture.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

std::string gzipped(const std::string& bytes) {
    z_stream stream = {};
    deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 9, Z_DEFAULT_STRATEGY);
    std::string packed(deflateBound(&stream, bytes.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = uInt(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = uInt(packed.size());
    deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
}

/// 3x4x5 of int16 if not said otherwise.
std::string header(const std::string& more, const std::string& encoding = "raw",
                   const std::string& sizes = "dimension: 3\nsizes: 3 4 5\n") {
    return "NRRD0005\ntype: signed short int\n" + sizes + "encoding: " + encoding + "\nendian: little\n" + more;
}

std::string text(const std::vector<std::int16_t>& samples) {
    std::string all;
    for (const std::int16_t sample : samples) all += std::to_string(sample) + (sample % 3 ? " " : ",\n");
    return all;
}

std::string hex(const std::string& bytes) {
    std::string all;
    for (const char c : bytes) {
        all += "0123456789abcdef"[static_cast<unsigned char>(c) >> 4];
        all += "0123456789ABCDEF"[c & 15];
    }
    return all + "\n";
}

class Nrrd : public Import {
  protected:
    std::vector<std::int16_t> numbers = labels<std::int16_t>(kDims);
    std::string bytes = bytesOf(numbers);

    /// The path of a file of this content.
    std::string file(const std::string& content, const std::string& name = "a.nrrd") {
        writeFile(folder / name, content);
        return folder / name;
    }
};

}  // namespace

TEST_F(Nrrd, EveryEncodingGivesTheSame) {
    expectLabels(importVolume({file(header("\n") + bytes)}, {}), kDims);
    expectLabels(importVolume({file(header("\n", "gzip") + gzipped(bytes))}, {}), kDims);
    expectLabels(
        importVolume({file(header("\n", "gz") + gzipped(bytes.substr(0, 50)) + gzipped(bytes.substr(50)))}, {}), kDims);
    expectLabels(importVolume({file(header("\n", "ascii") + text(numbers))}, {}), kDims);
    expectLabels(importVolume({file(header("\n", "hex") + hex(bytes))}, {}), kDims);
    expectError({file(header("\n", "bzip2") + bytes)}, "encoding 'bzip2' cannot be read");
}

TEST_F(Nrrd, SkipsAreHonoured) {
    expectLabels(importVolume({file(header("line skip: 2\nbyte skip: 3\n\n") + "one\ntwo\nabc" + bytes)}, {}), kDims);
    expectLabels(importVolume({file(header("byte skip: -1\n\n") + "whatever" + bytes)}, {}), kDims);
    expectLabels(importVolume({file(header("byte skip: 4\n\n", "gzip") + gzipped("abcd" + bytes))}, {}), kDims);
}

TEST_F(Nrrd, PlacesAreThoseOfTheHeader) {
    struct Case {
        std::string fields;
        Vec3 first, last;  ///< of voxels (0,0,0) and (1,1,1)
    };
    // Teem: where nothing else is said, samples are in the middle of cells.
    const Case cases[] = {
        {"spacings: 1 2 3\n", {0, 0, 0}, {1, 2, 3}},
        {"spacings: 1 2 -3\n", {0, 0, 0}, {1, 2, -3}},
        {"spacings: 1 2 nan\naxis mins: 10 20 nan\ncenters: node node node\n", {10, 20, 0}, {11, 22, 1}},
        {"spacings: 1 2 3\naxis mins: 10 20 30\n", {10.5, 21, 31.5}, {11.5, 23, 34.5}},
        {"axis mins: 0 0 0\naxis maxs: 6 8 20\ncenters: cell cell cell\n", {1, 1, 2}, {3, 3, 6}},
        {"axis mins: 0 0 0\naxis maxs: 4 6 20\ncenterings: node node node\n", {0, 0, 0}, {2, 2, 5}},
        {"space: RAS\nspace directions: (1,0,0) (0,2,0) (0.5,0,3)\nspace origin: (5,6,7)\n",
         {-5, -6, 7},
         {-6.5, -8, 10}},
        {"space: left-anterior-superior\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (5,6,7)\n",
         {5, -6, 7},
         {6, -8, 10}},
        {"space: scanner-xyz\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (5,6,7)\n",
         {5, 6, 7},
         {6, 8, 10}},
        {"space dimension: 3\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: none\n", {0, 0, 0}, {1, 2, 3}},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.fields);
        const ImportedVolume volume = importVolume({file(header(c.fields + "\n") + bytes)}, {});
        expectLabels(volume, kDims);
        expectAt(volume, Coord(0, 0, 0), c.first);
        expectAt(volume, Coord(1, 1, 1), c.last);
    }
}

TEST_F(Nrrd, UnitsAreToldAndMustBeOne) {
    const std::string space = "space: LPS\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace units: ";
    EXPECT_EQ(importVolume({file(header(space + "\"um\" \"um\" \"um\"\n\n") + bytes)}, {}).unit, "um");
    expectError({file(header(space + "\"mm\" \"mm\" \"um\"\n\n") + bytes)}, "in 'mm' along one axis and in 'um'");
    EXPECT_EQ(importVolume({file(header("units: \"cm\" \"cm\" \"cm\"\n\n") + bytes)}, {}).unit, "cm");
}

TEST_F(Nrrd, QuantizedSamplesAreSaidToBe) {
    const auto volume = importVolume({file(header("old min: -1\nold max: 1.5\n\n") + bytes)}, {});
    expectLabels(volume, kDims);
    ASSERT_EQ(volume.notes.size(), 1u);
    EXPECT_NE(volume.notes[0].find("from -1 to 1.5"), std::string::npos);
}

TEST_F(Nrrd, ChannelsAndVolumesAreListedAndChosen) {
    // Axes of channels and volumes wherever they are: samples tell channel and volume by thousands.
    struct Case {
        std::string fields, error;
        int channelAxis, volumeAxis;  ///< of five, -1: there is none
    };
    const std::string none = "space dimension: 3\nspace directions: ";
    const Case cases[] = {
        {"kinds: RGB-color domain domain domain list\n", "holds 3 channels (kinds: rgb-color)", 0, 4},
        {"kinds: domain domain vector domain time\n", "holds 3 channels (kinds: vector)", 2, 4},
        {"kinds: list domain domain domain 3-vector\n", "choose one by `channel`: 0 x, 1 y, 2 z", 4, 0},
        {none + "none (1,0,0) (0,1,0) (0,0,1) none\n", "holds 3 channels", 0, 4},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.fields);
        std::vector<int> sizes(5);
        const int spatial[] = {3, 4, 5};
        for (int axis = 0, n = 0; axis < 5; ++axis)
            sizes[std::size_t(axis)] = axis == c.channelAxis ? 3 : axis == c.volumeAxis ? 2 : spatial[n++];
        std::vector<std::int16_t> samples;
        for (int at = 0, total = 3 * 4 * 5 * 6; at < total; ++at) {
            int rest = at, index[3] = {}, channel = 0, volume = 0;
            for (int axis = 0, n = 0; axis < 5; ++axis) {
                const int here = rest % sizes[std::size_t(axis)];
                rest /= sizes[std::size_t(axis)];
                (axis == c.channelAxis ? channel : axis == c.volumeAxis ? volume : index[n++]) = here;
            }
            samples.push_back(std::int16_t(label(index[0], index[1], index[2]) + 1000 * channel + 5000 * volume));
        }
        std::string size = "dimension: 5\nsizes:";
        for (const int s : sizes) size += " " + std::to_string(s);
        const std::string path = file(header(c.fields + "\n", "gzip", size + "\n") + gzipped(bytesOf(samples)));
        expectError({path}, c.error);
        ImportOptions options;
        for (int channel = 0; channel < 3; ++channel)
            for (int volume = 0; volume < 2; ++volume) {
                options.channel = channel, options.volumeIndex = volume;
                const ImportedVolume chosen = importVolume({path}, options);
                ASSERT_EQ(chosen.dims, kDims);
                for (const Coord& at : {Coord(0, 0, 0), Coord(2, 1, 4), Coord(1, 3, 2)})
                    EXPECT_EQ(chosen.grid->tree().getValue(at),
                              label(at.x(), at.y(), at.z()) + 1000 * channel + 5000 * volume);
            }
        options.channel = 3;
        expectError({path}, "channel 3: ", options);
    }
    const std::string plain = file(header("\n", "raw", "dimension: 4\nsizes: 3 4 1 5\n") + bytes);
    expectError({plain}, "holds 5 volumes of 3x4x1, and one is wanted; choose one by `volumeIndex`: 0 to 4");
    ImportOptions options;
    options.channel = 1;
    expectError({file(header("\n") + bytes)},
                "channel 1: '" + folder / "a.nrrd" + "' holds one, which has the number 0", options);
}

TEST_F(Nrrd, DataMayBeInFilesOfTheirOwn) {
    for (int k = 0; k < 5; ++k) file(bytes.substr(std::size_t(24 * k), 24), "s0" + std::to_string(k) + ".raw");
    file(bytes, "all.raw");
    file("head" + bytes, "long.raw");
    file(bytes.substr(1), "short.raw");
    std::filesystem::create_symlink("/dev/zero", folder / "endless.raw");
    const auto detached = [&](const std::string& data) { return file(header("data file: " + data + "\n"), "a.nhdr"); };
    expectLabels(importVolume({detached("all.raw")}, {}), kDims);
    expectLabels(importVolume({detached("LIST\ns00.raw\ns01.raw\ns02.raw\ns03.raw\ns04.raw")}, {}), kDims);
    expectLabels(importVolume({detached("s%02d.raw 0 4 1")}, {}), kDims);
    expectError({detached("s%02d.raw 0 5 1")}, "s05.raw': there is no such file");
    expectError({detached("s%02d.raw 0 2 1")}, "are needed, there are 24");
    expectError({detached("long.raw")}, "its data go on behind the samples");
    expectError({detached("short.raw")}, "120 bytes of samples are needed, there are 119");
    expectError({detached("gone.raw")}, "gone.raw': there is no such file");
    expectError({detached("a.nhdr")}, "the file of its own data");
    expectError({detached("endless.raw")}, "a device or a pipe");
    expectError({detached("%s%n%d 1 100000000 1")}, "must have one number such as %d");
    expectError({detached("%d 1 100000000 1")}, "more than there can be");
    expectError({detached("%*d 1 2 1")}, "must have one number");
    expectError({detached("LIST")}, "are missing");
}

TEST_F(Nrrd, HeadersThatAreNotToBeTrustedAreRefusedAtOnce) {
    const auto refuse = [&](const std::string& content, const std::string& part) {
        expectError({file(content)}, part);
    };
    refuse("NRRD0004\ntype: short\ndimension: 3\n" + std::string(2000, '1') + "\n", "line 4: it is not of the form");
    refuse("NRRD0004\n#" + std::string(3 << 20, 'x'), "longer than any line");
    refuse(header("wobble: 3\n\n") + bytes, "NRRD has no field 'wobble'");
    refuse(header("encoding: raw\n\n") + bytes, "given twice");
    refuse(header("\n", "raw", "dimension: 3\nsizes: 2147483647 2147483647 2147483647\n") + bytes,
           "more samples than any file holds");
    refuse(header("\n", "raw", "dimension: 3\nsizes: 100000 1000 1000\n") + bytes, "there are 120");
    refuse(header("\n", "gzip", "dimension: 3\nsizes: 100000 1000 1000\n") + gzipped(bytes), "end too early");
    refuse(header("\n", "raw", "dimension: 3\nsizes: 3 -4 5\n") + bytes, "each larger than 0");
    refuse(header("\n", "raw", "dimension: 3\nsizes: 3 4\n") + bytes, "sizes '3 4'");
    refuse(header("\n", "raw", "dimension: 1000000000\nsizes: 3 4\n") + bytes, "none from 1 to 16");
    refuse(header("spacings: 1 0 1\n\n") + bytes, "a spacing is 0");
    refuse(header("space: LPS\nspace directions: (1,0) (0,1) (1,1)\n\n") + bytes, "vectors of another length");
    refuse(header("space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,inf)\n\n") + bytes, "is not finite");
    refuse(header("space: LPS\nspace directions: (1,0,0) (0,1,0) (1,1,0)\n\n") + bytes, "span no volume");
    refuse(header("spacings: 1e-6 1e-6 1e-6\n\n") + bytes, "voxels are too small for a grid");
    refuse("NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 5\nencoding: raw\n\n" + bytes, "endian must be");
    refuse("NRRD0004\ntype: block\nblock size: 2\ndimension: 3\nsizes: 3 4 5\nencoding: raw\n\n" + bytes,
           "blocks of bytes");
    const std::string packed = gzipped(bytes);
    refuse(header("\n", "gzip") + packed.substr(0, packed.size() / 2), "end too early");
    std::string wrong = packed;
    wrong[packed.size() - 6] ^= 1;  // the check sum
    refuse(header("\n", "gzip") + wrong, "damaged");
    refuse(header("\n", "ascii") + "1 2 three " + text(numbers), "'three' is no int16");
    refuse(header("\n", "ascii") + "1 2 40000 " + text(numbers), "'40000' is no int16");
}
