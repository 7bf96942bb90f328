// Source: Kitware, MetaIO documentation (MetaImage tags), and what its reader does where that says nothing.
#include "raysweep/formats/meta_image.h"

#include "raysweep/core/error.h"
#include "raysweep/formats/data_files.h"
#include "raysweep/formats/declared_samples.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"
#include "raysweep/formats/rescale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace raysweep {
namespace {

struct Header {
    std::string path;
    std::map<std::string, std::string> tags;
    std::vector<std::string> listed;  ///< data files, where the tag says LIST
    std::uint64_t end = 0;            ///< where data are that are in the same file

    [[noreturn]] void fail(const std::string& why) const {
        failRead(path, "in its header: " + why + "; it is no MetaImage, or damaged");
    }
    bool has(const std::string& tag) const { return tags.count(tag) > 0; }
    std::string of(const std::string& tag) const {
        const auto found = tags.find(tag);
        return found == tags.end() ? "" : found->second;
    }
    /// One of the names that one tag has; empty: none is there. @throw IoError if two of them contradict each other
    std::string tagOf(std::initializer_list<const char*> names) const {
        std::string found;
        for (const char* name : names)
            if (has(name) && !found.empty() && of(name) != of(found))
                fail(found + " and " + name + " mean the same, but say different things");
            else if (has(name))
                found = name;
        return found;
    }
    /// `count` numbers, finite; `otherwise` where the tag is missing.
    std::vector<double> numbers(const std::string& tag, std::size_t count, std::vector<double> otherwise) const {
        if (tag.empty() || !has(tag)) return otherwise;
        std::vector<double> found;
        const bool sound = toNumbers(of(tag), found) && found.size() == count &&
                           std::all_of(found.begin(), found.end(), [](double n) { return std::isfinite(n); });
        if (!sound) fail(tag + " '" + of(tag).substr(0, 200) + "' is not " + std::to_string(count) + " finite numbers");
        return found;
    }
    std::int64_t whole(const std::string& tag, std::int64_t otherwise) const {
        std::int64_t number = otherwise;
        if (has(tag) && !toWhole(of(tag), number)) fail(tag + " '" + of(tag) + "' is no whole number");
        return number;
    }
    bool flag(const std::string& tag, bool otherwise) const {
        const std::string text = lowerCase(of(tag));
        if (text.empty()) return otherwise;
        if (text == "true" || text == "1") return true;
        if (text == "false" || text == "0") return false;
        fail(tag + " '" + of(tag) + "' is neither True nor False");
    }
};

Header readHeader(const std::string& path) {
    HeaderLines lines(path);
    Header header;
    header.path = path;
    std::string line;
    while (lines.next(line)) {
        if (trimmed(line).empty()) continue;
        const std::size_t separator = line.find_first_of("=:");
        if (separator == std::string::npos)
            lines.fail("it is not of the form 'Key = value'; it is no MetaImage, or damaged");
        const std::string tag = trimmed(line.substr(0, separator));
        if (!header.tags.emplace(tag, trimmed(line.substr(separator + 1))).second) lines.fail(tag + " is given twice");
        if (tag != "ElementDataFile") continue;
        header.end = lines.position();
        const std::vector<std::string> words = wordsOf(header.of(tag));
        if (!words.empty() && words[0] == "LIST")
            while (lines.next(line))
                if (!trimmed(line).empty()) header.listed.push_back(trimmed(line));
        return header;
    }
    header.fail(header.tags.empty() ? "there is none" : "ElementDataFile is missing");
}

SampleType typeOf(const Header& header) {
    static const std::map<std::string, SampleType> kTypes = {
        {"MET_CHAR", SampleType::int8},         {"MET_ASCII_CHAR", SampleType::int8},
        {"MET_UCHAR", SampleType::uint8},       {"MET_SHORT", SampleType::int16},
        {"MET_USHORT", SampleType::uint16},     {"MET_INT", SampleType::int32},
        {"MET_UINT", SampleType::uint32},       {"MET_LONG", SampleType::int32},
        {"MET_ULONG", SampleType::uint32},      {"MET_LONG_LONG", SampleType::int64},
        {"MET_ULONG_LONG", SampleType::uint64}, {"MET_FLOAT", SampleType::float32},
        {"MET_DOUBLE", SampleType::float64}};
    std::string name = header.of("ElementType");
    if (const std::size_t array = name.rfind("_ARRAY"); array != std::string::npos) name.resize(array);
    const auto found = kTypes.find(name);
    if (found == kTypes.end()) header.fail("ElementType '" + header.of("ElementType") + "' is no type of numbers");
    return found->second;
}

/// DimSize.
std::vector<std::int64_t> sizesOf(const Header& header) {
    constexpr std::int64_t kMost = 10;  // as MetaIO
    const std::int64_t dimensions = header.whole("NDims", 0);
    if (dimensions < 1 || dimensions > kMost) header.fail("NDims '" + header.of("NDims") + "' is none from 1 to 10");
    std::vector<std::int64_t> sizes;
    if (!toWholes(header.of("DimSize"), sizes) || std::int64_t(sizes.size()) != dimensions ||
        *std::min_element(sizes.begin(), sizes.end()) < 1)
        header.fail("DimSize '" + header.of("DimSize").substr(0, 200) + "' is not NDims numbers, each larger than 0");
    return sizes;
}

/// Channels are side by side, axes after the third count volumes.
void declareAxes(const Header& header, const std::vector<std::int64_t>& sizes, const VolumeChoice& choice,
                 DeclaredSamples& samples) {
    const std::int64_t channels = header.whole("ElementNumberOfChannels", 1);
    if (channels < 1 || channels > std::numeric_limits<std::int32_t>::max())
        header.fail("ElementNumberOfChannels is " + header.of("ElementNumberOfChannels"));
    samples.axes.push_back({channels, false});
    double volumes = 1;
    std::string shape;
    for (std::size_t n = 0; n < sizes.size(); ++n) {
        samples.axes.push_back({sizes[n], n < 3});
        if (n < 3) shape += (n > 0 ? "x" : "") + std::to_string(sizes[n]);
        if (n >= 3) volumes *= double(sizes[n]);
    }
    bytesOf(samples, header.path);  // so that their number can be told
    if (volumes > std::numeric_limits<std::int32_t>::max()) header.fail("it promises more volumes than there can be");
    samples.axes[0].chosen = chooseChannel(header.path, {std::uint64_t(channels), "channels", {}}, choice);
    std::int64_t chosen = chooseVolume(header.path, {std::uint64_t(volumes), "volumes of " + shape, {}}, choice);
    for (std::size_t n = 4; n < samples.axes.size(); ++n) {
        samples.axes[n].chosen = chosen % samples.axes[n].size;
        chosen /= samples.axes[n].size;
    }
}

/// The files of samples; none: they are behind the header.
std::vector<std::string> dataFilesOf(const Header& header, const std::vector<std::int64_t>& sizes) {
    const std::string file = header.of("ElementDataFile");
    const std::vector<std::string> words = wordsOf(file);
    if (words.empty()) header.fail("ElementDataFile names no file");
    if (words[0] == "LOCAL" || words[0] == "Local" || words[0] == "local") return {};
    std::vector<std::string> names = header.listed;
    if (words[0] == "LIST") {
        if (names.empty()) header.fail("its list of data files is empty");
    } else if (file.find('%') != std::string::npos && (words.size() > 1 || isNumberPattern(file))) {
        FileNumbers numbers{1, sizes.back(), 1};
        std::int64_t* const fields[] = {&numbers.first, &numbers.last, &numbers.step};
        if (words.size() > 4) header.fail("ElementDataFile has more than a pattern and three numbers");
        for (std::size_t n = 1; n < words.size(); ++n)
            if (!toWhole(words[n], *fields[n - 1])) header.fail("'" + words[n] + "' is no whole number");
        names = namesOf(header.path, words[0], numbers);
    } else {
        names.push_back(file);
    }
    for (std::string& name : names) name = fileBeside(header.path, name);
    return names;
}

void findPieces(const Header& header, const std::vector<std::int64_t>& sizes, DeclaredSamples& samples) {
    const std::vector<std::string> files = dataFilesOf(header, sizes);
    const std::int64_t skip = header.whole("HeaderSize", 0);
    if (skip < -1) header.fail("HeaderSize is negative");
    if (skip == -1 && samples.coding != SampleCoding::raw) header.fail("HeaderSize -1 is for raw data only");
    if (header.whole("HeaderSizePerSlice", 0) != 0)
        header.fail("HeaderSizePerSlice cannot be used: write one raw file");
    samples.exact = !files.empty();
    if (files.empty())
        samples.pieces.push_back({header.path, header.end});
    else
        for (const std::string& file : files) samples.pieces.push_back({file});
    splitEvenly(samples, header.path);
    for (DataPiece& piece : samples.pieces) {
        if (skip >= 0)
            piece.skip += std::uint64_t(skip);
        else if (const std::uint64_t size = sizeOfFile(piece.file); size >= piece.skip + piece.bytes)
            piece.skip = size - piece.bytes;
    }
}

/// Origin and steps. TransformMatrix holds the directions of the axes one after the other.
void place(const Header& header, std::size_t dimensions, StoredVolume& volume) {
    const std::string matrixTag = header.tagOf({"TransformMatrix", "Rotation", "Orientation"});
    const std::string originTag = header.tagOf({"Offset", "Position", "Origin"});
    std::vector<double> unity(dimensions * dimensions, 0);
    for (std::size_t n = 0; n < dimensions; ++n) unity[n * dimensions + n] = 1;
    const std::vector<double> zeros(dimensions, 0), ones(dimensions, 1);
    const std::vector<double> matrix = header.numbers(matrixTag, dimensions * dimensions, unity);
    const std::vector<double> origin = header.numbers(originTag, dimensions, zeros);
    const std::vector<double> size = header.numbers("ElementSize", dimensions, ones);
    const std::vector<double> spacing = header.numbers("ElementSpacing", dimensions, size);
    if (header.numbers("CenterOfRotation", dimensions, zeros) != zeros && matrix != unity)
        throw InvalidArgument("'" + header.path +
                              "' is turned about a centre (CenterOfRotation), which programs "
                              "understand in different ways; write its place with CenterOfRotation 0");
    for (std::size_t axis = 0; axis < std::min<std::size_t>(3, dimensions); ++axis) {
        Vec3 step(0);
        for (std::size_t n = 0; n < dimensions; ++n) {
            const double component = matrix[axis * dimensions + n];
            if (n < 3)
                step[int(n)] = component * spacing[axis];
            else if (component != 0)
                throw InvalidArgument("'" + header.path + "' has axes of space that run along its fourth dimension");
        }
        volume.steps[axis] = step;
        volume.origin[int(axis)] = origin[axis];
    }
    const std::string unit = header.of("DistanceUnits");
    volume.unit = unit.empty() || unit == "?" ? "mm" : unit;
}

}  // namespace

StoredVolume readMetaImage(const std::string& path, const VolumeChoice& choice, const ProgressCallback& progress) {
    const Header header = readHeader(path);
    if (header.has("ObjectType") && header.of("ObjectType") != "Image")
        header.fail("it is of the type '" + header.of("ObjectType").substr(0, 60) + "', not Image");
    const std::vector<std::int64_t> sizes = sizesOf(header);
    DeclaredSamples samples;
    samples.type = typeOf(header);
    declareAxes(header, sizes, choice, samples);
    const bool compressed = header.flag("CompressedData", false);
    if (compressed) samples.coding = SampleCoding::deflate;
    if (!header.flag("BinaryData", true)) {
        if (compressed) header.fail("its data are text and compressed at once");
        samples.coding = SampleCoding::text;
    }
    const std::string order = header.tagOf({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"});
    samples.bigEndian = samples.coding != SampleCoding::text && !order.empty() && header.flag(order, false);
    findPieces(header, sizes, samples);
    Rescaling intensity;
    intensity.slope = header.numbers("ElementToIntensityFunctionSlope", 1, {1})[0];
    intensity.intercept = header.numbers("ElementToIntensityFunctionOffset", 1, {0})[0];
    if (intensity.slope == 0) header.fail("ElementToIntensityFunctionSlope is 0: all samples would be one number");

    StoredVolume volume = readDeclared(path, samples, progress);
    volume.format = "MetaImage";
    place(header, sizes.size(), volume);
    if (volume.complete) rescale(volume, intensity);
    return volume;
}

}  // namespace raysweep
