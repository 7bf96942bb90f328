#include "raysweep/formats/nrrd_volume.h"

#include "raysweep/core/error.h"
#include "raysweep/formats/data_files.h"
#include "raysweep/formats/declared_samples.h"
#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/nrrd_axes.h"
#include "raysweep/formats/nrrd_header.h"
#include "raysweep/formats/read_failure.h"

#include <fstream>
#include <map>

namespace raysweep {
namespace {

SampleType typeOf(const NrrdHeader& header, const std::string& path) {
    std::vector<std::string> words = wordsOf(lowerCase(header.of("type")));  // "signed short int" and the like
    if (words.size() > 1 && words.front() == "signed") words.erase(words.begin());
    if (words.size() > 1 && words.back() == "int") words.pop_back();
    std::string name;
    for (const std::string& word : words) name += word;
    static const std::map<std::string, SampleType> kTypes = {
        {"char", SampleType::int8},          {"int8", SampleType::int8},
        {"int8_t", SampleType::int8},        {"uchar", SampleType::uint8},
        {"unsignedchar", SampleType::uint8}, {"uint8", SampleType::uint8},
        {"uint8_t", SampleType::uint8},      {"short", SampleType::int16},
        {"int16", SampleType::int16},        {"int16_t", SampleType::int16},
        {"ushort", SampleType::uint16},      {"unsignedshort", SampleType::uint16},
        {"uint16", SampleType::uint16},      {"uint16_t", SampleType::uint16},
        {"int", SampleType::int32},          {"int32", SampleType::int32},
        {"int32_t", SampleType::int32},      {"uint", SampleType::uint32},
        {"unsigned", SampleType::uint32},    {"uint32", SampleType::uint32},
        {"uint32_t", SampleType::uint32},    {"longlong", SampleType::int64},
        {"int64", SampleType::int64},        {"int64_t", SampleType::int64},
        {"ulonglong", SampleType::uint64},   {"unsignedlonglong", SampleType::uint64},
        {"uint64", SampleType::uint64},      {"uint64_t", SampleType::uint64},
        {"float", SampleType::float32},      {"double", SampleType::float64}};
    const auto found = kTypes.find(name);
    if (found == kTypes.end())
        failRead(path, "in its header: type '" + header.of("type") + "' is none of NRRD's for a number");
    return found->second;
}

SampleCoding codingOf(const NrrdHeader& header, const std::string& path) {
    static const std::map<std::string, SampleCoding> kCodings = {
        {"raw", SampleCoding::raw},  {"gz", SampleCoding::deflate}, {"gzip", SampleCoding::deflate},
        {"txt", SampleCoding::text}, {"text", SampleCoding::text},  {"ascii", SampleCoding::text},
        {"hex", SampleCoding::hex}};
    const auto found = kCodings.find(lowerCase(header.of("encoding")));
    if (found != kCodings.end()) return found->second;
    failRead(path, "in its header: encoding '" + header.of("encoding") +
                       "' cannot be read; save it as raw, gzip, ascii or hex");
}

bool isBigEndian(const NrrdHeader& header, const DeclaredSamples& samples, const std::string& path) {
    const std::string endian = lowerCase(header.of("endian"));
    if (endian == "big") return samples.coding != SampleCoding::text;
    if (endian == "little") return false;
    if (endian.empty() && (sizeOf(samples.type) == 1 || samples.coding == SampleCoding::text)) return false;
    failRead(path,
             "in its header: endian must be little or big, it is " + (endian.empty() ? "missing" : "'" + endian + "'"));
}

std::int64_t wholeField(const NrrdHeader& header, const std::string& field, const std::string& path) {
    std::int64_t number = 0;
    if (header.has(field) && !toWhole(header.of(field), number))
        failRead(path, "in its header: " + field + " '" + header.of(field) + "' is no whole number");
    return number;
}

/// The files that hold the samples; none: they are behind the header.
std::vector<std::string> dataFilesOf(const NrrdHeader& header, const std::string& path) {
    std::vector<std::string> names = header.listed;
    const std::string field = header.of("datafile");
    const std::vector<std::string> words = wordsOf(field);
    FileNumbers numbers;
    const bool counted = (words.size() == 4 || words.size() == 5) && words[0].find('%') != std::string::npos &&
                         toWhole(words[1], numbers.first) && toWhole(words[2], numbers.last) &&
                         toWhole(words[3], numbers.step);
    if (counted) names = namesOf(path, words[0], numbers);
    if (names.empty() && header.has("datafile")) {
        if (words.empty() || words[0] == "LIST")
            failRead(path, "in its header: the names of its data files are missing");
        names.push_back(field);
    }
    for (std::string& name : names) name = fileBeside(path, name);
    return names;
}

/// Where the line after `lines` lines begins.
std::uint64_t afterLines(const std::string& file, std::uint64_t from, std::int64_t lines) {
    std::ifstream in(file, std::ios::binary);
    in.seekg(std::streamoff(from));
    std::uint64_t at = from;
    for (; lines > 0 && in; ++at)
        if (in.get() == '\n') --lines;
    if (!in) failRead(file, "it has fewer lines than its header tells to skip");
    return at;
}

void findPieces(const NrrdHeader& header, const std::string& path, DeclaredSamples& samples) {
    const std::vector<std::string> files = dataFilesOf(header, path);
    const std::int64_t lines = wholeField(header, "lineskip", path), bytes = wholeField(header, "byteskip", path);
    if (lines < 0 || bytes < -1) failRead(path, "in its header: it tells to skip fewer than no lines or bytes");
    if (bytes == -1 && samples.coding != SampleCoding::raw)
        failRead(path, "in its header: a byte skip of -1 is for raw data only");
    samples.exact = !files.empty();
    if (files.empty())
        samples.pieces.push_back({path, header.end});
    else
        for (const std::string& file : files) samples.pieces.push_back({file});
    splitEvenly(samples, path);
    for (DataPiece& piece : samples.pieces) {
        piece.skip = afterLines(piece.file, piece.skip, lines);
        if (samples.coding == SampleCoding::deflate)
            piece.skipUnpacked = std::uint64_t(bytes);
        else if (bytes >= 0)
            piece.skip += std::uint64_t(bytes);
        else if (const std::uint64_t size = sizeOfFile(piece.file); size >= piece.skip + piece.bytes)
            piece.skip = size - piece.bytes;
    }
}

}  // namespace

StoredVolume readNrrd(const std::string& path, const VolumeChoice& choice, const ProgressCallback& progress) {
    const NrrdHeader header = readNrrdHeader(path);
    DeclaredSamples samples;
    if (trimmed(lowerCase(header.of("type"))) == "block")
        throw InvalidArgument("'" + path + "' holds blocks of bytes, whose meaning it does not say, and no numbers");
    samples.type = typeOf(header, path);
    samples.coding = codingOf(header, path);
    samples.bigEndian = isBigEndian(header, samples, path);
    const NrrdAxes axes = nrrdAxes(header, path, choice);
    samples.axes = axes.axes;
    findPieces(header, path, samples);

    StoredVolume volume = readDeclared(path, samples, progress);
    volume.format = "NRRD";
    volume.origin = axes.origin;
    volume.steps = axes.steps;
    volume.unit = axes.unit;
    if (header.has("oldmin") || header.has("oldmax"))
        volume.notes.push_back("its samples stand for values from " + header.of("oldmin") + " to " +
                               header.of("oldmax") + " (old min, old max), and were taken as they are stored");
    return volume;
}

}  // namespace raysweep
