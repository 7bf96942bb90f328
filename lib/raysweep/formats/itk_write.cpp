#include "raysweep/core/error.h"
#include "raysweep/formats/itk_formats.h"
#include "raysweep/formats/itk_silence.h"

#include <itkMetaImageIO.h>

#include <cmath>
#include <filesystem>
#include <vector>

namespace raysweep {

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
        throw IoError(error.GetDescription());
    }
    // A full disk goes unnoticed by MetaImage's writer.
    const auto least = std::uintmax_t(dims.x) * std::uintmax_t(dims.y) * std::uintmax_t(dims.z) * sizeof(float);
    std::error_code failed;
    const auto written = std::filesystem::file_size(path, failed);
    if (failed || written < least) throw IoError("is the disk full?");
}

}  // namespace raysweep
