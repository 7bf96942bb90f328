// ITK's image readers are used without its image classes: a reader fills the buffer that becomes the grid, so nothing
// is held twice, and none of ITK's templates is compiled.
#include "raysweep/core/error.h"
#include "raysweep/formats/itk_formats.h"
#include "raysweep/formats/itk_read.h"
#include "raysweep/formats/meta_image_check.h"
#include "raysweep/formats/nifti_check.h"

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <cmath>
#include <filesystem>

namespace raysweep {
namespace {

itk::ImageIOBase::Pointer readerFor(ItkFormat format) {
    switch (format) {
        case ItkFormat::nrrd:
            return itk::NrrdImageIO::New().GetPointer();
        case ItkFormat::metaImage:
            return itk::MetaImageIO::New().GetPointer();
        case ItkFormat::nifti:
            break;
    }
    return itk::NiftiImageIO::New().GetPointer();
}

const char* nameOf(ItkFormat format) {
    return format == ItkFormat::nrrd ? "NRRD" : format == ItkFormat::metaImage ? "MetaImage" : "NIfTI";
}

/// Dimensions after the third must be 1.
void requireVolume(const itk::ImageIOBase& io, const std::string& path) {
    std::uint64_t volumes = 1;
    for (unsigned axis = 3; axis < io.GetNumberOfDimensions(); ++axis) volumes *= io.GetDimensions(axis);
    if (volumes != 1)
        throw InvalidArgument("'" + path + "' has " + std::to_string(io.GetNumberOfDimensions()) +
                              " dimensions: " + std::to_string(volumes) + " volumes of " +
                              std::to_string(io.GetDimensions(0)) + "x" + std::to_string(io.GetDimensions(1)) + "x" +
                              std::to_string(io.GetDimensions(2)) + "; give a file with one of them");
}

/// Data that are missing: MetaImage's reader prints that to the console and returns as if nothing had happened.
void requireNoComplaint(const Silence& silence, const std::string& path) {
    if (!silence.said().empty()) failRead(path, "the data end too early or are damaged (" + silence.said() + ")");
}

}  // namespace

StoredVolume itkVolume(const std::string& path, ItkFormat format, const ProgressCallback& progress) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) failRead(path, "there is no such file");
    if (std::filesystem::is_directory(path, ignored)) failRead(path, "it is a folder");
    const Silence silence;
    if (format == ItkFormat::nifti) checkNifti(path);
    if (format == ItkFormat::metaImage) checkMetaImage(path);
    const itk::ImageIOBase::Pointer io = readerFor(format);
    StoredVolume volume;
    guarded(path, "header", silence, [&] {
        io->SetFileName(path);
        io->ReadImageInformation();
        requireVolume(*io, path);
        volume = describe(*io, path);
    });
    volume.format = nameOf(format);
    volume.complete = report(progress, "reading", 0);
    if (!volume.complete) return volume;
    volume.samples.reset(new std::byte[volume.count() * sizeOf(volume.type)]);
    guarded(path, "data", silence, [&] { readInto(*io, volume.samples.get()); });
    if (format == ItkFormat::metaImage) requireNoComplaint(silence, path);
    volume.complete = report(progress, "reading", 1);
    return volume;
}

void itkWrite(const std::string& path, const Index3& dims, const float* samples, const Vec3& origin,
              const Vec3& spacing) {
    const Silence silence;
    const auto io = itk::MetaImageIO::New();
    io->SetNumberOfDimensions(3);
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = unsigned(axis);
        io->SetDimensions(a, std::size_t(dims[axis]));
        io->SetOrigin(a, origin[axis]);
        io->SetSpacing(a, std::abs(spacing[axis]));  // ITK knows positive ones only
        std::vector<double> direction(3, 0.0);
        direction[a] = spacing[axis] < 0 ? -1 : 1;
        io->SetDirection(a, direction);
    }
    itk::ImageIORegion all(3);
    for (unsigned axis = 0; axis < 3; ++axis) all.SetSize(axis, std::size_t(dims[int(axis)]));
    io->SetIORegion(all);
    io->SetPixelType(itk::IOPixelEnum::SCALAR);
    io->SetNumberOfComponents(1);
    io->SetComponentType(itk::IOComponentEnum::FLOAT);
    io->SetUseCompression(false);
    io->SetFileName(path);
    try {
        io->Write(samples);
    } catch (const itk::ExceptionObject& error) {
        throw IoError(reasonOf(error));
    }
    // A full disk goes unnoticed by MetaImage's writer.
    const auto least = std::uintmax_t(dims.x) * std::uintmax_t(dims.y) * std::uintmax_t(dims.z) * sizeof(float);
    std::error_code failed;
    const auto written = std::filesystem::file_size(path, failed);
    if (failed || written < least) throw IoError("is the disk full?");
}

}  // namespace raysweep
