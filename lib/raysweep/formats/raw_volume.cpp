#include "raysweep/formats/raw_volume.h"

#include "raysweep/core/error.h"
#include "raysweep/formats/declared_samples.h"
#include "raysweep/formats/header_lines.h"

namespace raysweep {
namespace {

std::string listOf(const Index3& dims) {
    return std::to_string(dims.x) + "," + std::to_string(dims.y) + "," + std::to_string(dims.z);
}

/// Samples that `dims` stand for; throws where the number cannot be meant.
std::uint64_t sampleCount(const Index3& dims) {
    for (int axis = 0; axis < 3; ++axis)
        if (dims[axis] < 1) throw InvalidArgument("dims are " + listOf(dims) + ", but each must be at least 1");
    const double count = double(dims.x) * dims.y * dims.z;
    if (!(count < 9e15)) throw InvalidArgument("dims " + listOf(dims) + " are more voxels than any file holds");
    return std::uint64_t(dims.x) * std::uint64_t(dims.y) * std::uint64_t(dims.z);
}

/// What the user may have meant, given what the file holds.
std::string whatWouldFit(const RawLayout& layout, std::uint64_t count, std::uint64_t size) {
    const std::uint64_t rest = size > layout.skip ? size - layout.skip : 0;
    const std::uint64_t slice = count / std::uint64_t(layout.dims.z) * sizeOf(layout.type);
    std::string fits;
    const auto add = [&](const std::string& what) { fits += (fits.empty() ? "" : ", or ") + what; };
    for (const SampleType type : {SampleType::uint8, SampleType::uint16, SampleType::float32, SampleType::float64})
        if (sizeOf(type) != sizeOf(layout.type) && count * sizeOf(type) == rest)
            add("samples of " + std::to_string(sizeOf(type)) + " byte" + (sizeOf(type) > 1 ? "s" : "") + " such as " +
                nameOf(type));
    if (rest > 0 && rest % slice == 0)
        add("dims " + listOf(Index3(layout.dims.x, layout.dims.y, int(rest / slice))) + " of " + nameOf(layout.type));
    if (const std::uint64_t needed = count * sizeOf(layout.type); size > needed)
        add("a header of " + std::to_string(size - needed) + " bytes to skip");
    return fits.empty() ? "check dims, type and the bytes to skip" : "it would fit " + fits;
}

}  // namespace

StoredVolume readRawVolume(const std::string& path, const RawLayout& layout, const ProgressCallback& progress) {
    const std::uint64_t count = sampleCount(layout.dims), bytes = count * sizeOf(layout.type);
    const std::uint64_t size = sizeOfFile(path);
    if (size != layout.skip + bytes)
        throw InvalidArgument("'" + path + "' has " + std::to_string(size) + " bytes, but " + listOf(layout.dims) +
                              " of " + nameOf(layout.type) + " after " + std::to_string(layout.skip) +
                              " skipped bytes are " + std::to_string(layout.skip + bytes) + "; " +
                              whatWouldFit(layout, count, size));
    DeclaredSamples samples;
    samples.type = layout.type;
    samples.bigEndian = layout.bigEndian;
    for (int axis = 0; axis < 3; ++axis) samples.axes.push_back({layout.dims[axis], true});
    samples.pieces.push_back({path, layout.skip});
    splitEvenly(samples, path);
    StoredVolume volume = readDeclared(path, samples, progress);
    volume.format = "raw";
    return volume;
}

}  // namespace raysweep
