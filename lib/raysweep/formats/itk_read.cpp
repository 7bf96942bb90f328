#include "raysweep/formats/itk_read.h"

#include "raysweep/core/error.h"

#include <gdcmTrace.h>
#include <nifti1_io.h>

#include <cmath>
#include <regex>

namespace raysweep {
namespace {

SampleType sampleTypeOf(const itk::ImageIOBase& io, const std::string& path) {
    using Type = itk::IOComponentEnum;
    switch (io.GetComponentType()) {
        case Type::CHAR:
            return SampleType::int8;
        case Type::UCHAR:
            return SampleType::uint8;
        case Type::SHORT:
            return SampleType::int16;
        case Type::USHORT:
            return SampleType::uint16;
        case Type::INT:
            return SampleType::int32;
        case Type::UINT:
            return SampleType::uint32;
        case Type::LONG:
            return sizeof(long) == 8 ? SampleType::int64 : SampleType::int32;
        case Type::ULONG:
            return sizeof(long) == 8 ? SampleType::uint64 : SampleType::uint32;
        case Type::LONGLONG:
            return SampleType::int64;
        case Type::ULONGLONG:
            return SampleType::uint64;
        case Type::FLOAT:
            return SampleType::float32;
        case Type::DOUBLE:
            return SampleType::float64;
        default:
            failRead(path, "the type of its voxels is not known");
    }
}

/// Component `n`; 0 where the file has fewer dimensions.
double at(const std::vector<double>& v, std::size_t n) {
    return n < v.size() ? v[n] : 0;
}

std::string oneLine(const std::string& text) {
    std::istringstream lines(text);
    std::string all;
    for (std::string line; std::getline(lines, line);) {
        const std::size_t begin = line.find_first_not_of(" \t\r"), end = line.find_last_not_of(" \t\r.");
        if (begin != std::string::npos && end != std::string::npos)
            all += (all.empty() ? "" : "; ") + line.substr(begin, end - begin + 1);
    }
    return all;
}

}  // namespace

void failRead(const std::string& path, const std::string& why) {
    throw IoError("cannot read '" + path + "': " + why);
}

Silence::Silence() : cerr_(std::cerr.rdbuf(kept_.rdbuf())), cout_(std::cout.rdbuf(kept_.rdbuf())) {
    itk::Object::SetGlobalWarningDisplay(false);
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    gdcm::Trace::DebugOff();
    nifti_set_debug_level(0);
}

Silence::~Silence() {
    std::cerr.rdbuf(cerr_);
    std::cout.rdbuf(cout_);
}

std::string Silence::said() const {
    return oneLine(kept_.str());
}

std::string reasonOf(const itk::ExceptionObject& error) {
    // "itk::ERROR: Class(0x1234): what happened", or a trace whose last line "[nrrd] function: why" has the cause.
    std::istringstream lines(error.GetDescription());
    std::string reason;
    for (std::string line; std::getline(lines, line);)
        if (line.find_first_not_of(" \t") != std::string::npos) reason = line;
    reason = std::regex_replace(reason, std::regex(R"(^\s*(itk::|ITK )ERROR: (\w+\([^)]*\): )?)"), "");
    return oneLine(std::regex_replace(reason, std::regex(R"(^\[\w+\] \w+: )"), ""));
}

StoredVolume describe(const itk::ImageIOBase& io, const std::string& path) {
    StoredVolume volume;
    volume.dims = Index3(1);
    double count = 1;
    for (unsigned axis = 0; axis < std::min(3u, io.GetNumberOfDimensions()); ++axis) {
        const auto size = io.GetDimensions(axis);
        if (size < 1 || size > 0x7fffffff) failRead(path, "its header promises no voxels, or more than there can be");
        volume.dims[int(axis)] = int(size);
        count *= double(size);
        volume.origin[int(axis)] = io.GetOrigin(axis);
        const std::vector<double> direction = io.GetDirection(axis);
        volume.steps[axis] = Vec3(at(direction, 0), at(direction, 1), at(direction, 2)) * io.GetSpacing(axis);
    }
    if (io.GetNumberOfComponents() != 1)
        throw InvalidArgument(
            "'" + path + "' has " + std::to_string(io.GetNumberOfComponents()) +
            " numbers per voxel (colour, vectors or complex numbers), but a volume needs one; convert "
            "it to grey first");
    volume.type = sampleTypeOf(io, path);
    if (!(count < 1e15)) failRead(path, "its header promises more voxels than there can be");
    return volume;
}

void readInto(itk::ImageIOBase& io, void* to) {
    itk::ImageIORegion all(io.GetNumberOfDimensions());
    for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
        all.SetIndex(axis, 0);
        all.SetSize(axis, io.GetDimensions(axis));
    }
    io.SetIORegion(all);
    io.Read(to);
}

}  // namespace raysweep
