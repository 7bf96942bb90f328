/// itk_reader FILE: what ITK, which shares no code with Raysweep, finds in a volume: dims, place, steps and samples, as
/// JSON. Another witness for files that Raysweep writes.
#include <itkImageIOBase.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace {

itk::ImageIOBase::Pointer readerOf(const std::string& path) {
    if (path.find(".mha") != std::string::npos) return itk::MetaImageIO::New().GetPointer();
    if (path.find(".nrrd") != std::string::npos) return itk::NrrdImageIO::New().GetPointer();
    return itk::NiftiImageIO::New().GetPointer();
}

int print(const std::string& path) {
    const itk::ImageIOBase::Pointer io = readerOf(path);
    io->SetFileName(path);
    io->ReadImageInformation();
    if (io->GetComponentType() != itk::IOComponentEnum::FLOAT || io->GetNumberOfDimensions() != 3) return 1;
    itk::ImageIORegion all(3);
    for (unsigned axis = 0; axis < 3; ++axis) all.SetSize(axis, io->GetDimensions(axis));
    io->SetIORegion(all);
    std::vector<float> samples(io->GetImageSizeInPixels());
    io->Read(samples.data());
    std::printf("{\"dims\": [%d, %d, %d], \"steps\": [", int(io->GetDimensions(0)), int(io->GetDimensions(1)),
                int(io->GetDimensions(2)));
    for (unsigned axis = 0; axis < 3; ++axis) {
        const std::vector<double> d = io->GetDirection(axis);
        const double s = io->GetSpacing(axis);
        std::printf("%s[%.17g, %.17g, %.17g]", axis > 0 ? ", " : "", d[0] * s, d[1] * s, d[2] * s);
    }
    std::printf("], \"origin\": [%.17g, %.17g, %.17g], \"samples\": [", io->GetOrigin(0), io->GetOrigin(1),
                io->GetOrigin(2));
    for (std::size_t n = 0; n < samples.size(); ++n) std::printf("%s%.9g", n > 0 ? ", " : "", double(samples[n]));
    std::printf("]}\n");
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return argc == 2 ? print(argv[1]) : 2;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
