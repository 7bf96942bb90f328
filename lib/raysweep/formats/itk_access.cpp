// What itk_volume.h promises, by the module that holds ITK.
#include "raysweep/core/error.h"
#include "raysweep/core/module.h"
#include "raysweep/formats/itk_formats.h"

namespace raysweep {
namespace {

const ModuleFunction& function() {
    static const ModuleFunction found = moduleFunction("raysweep_medical", "raysweepItkFormats");
    return found;
}

/// What reads and writes. @param what for messages: "read" or "write" @throw IoError if there is nothing
const ItkFormats& formatsFor(const std::string& path, const char* what = "read") {
    if (!function().address)
        throw IoError(std::string("cannot ") + what + " '" + path +
                      "': this build of Raysweep has no ITK, which knows NRRD, MetaImage, NIfTI and DICOM; install "
                      "libinsighttoolkit5-dev and configure again with -DRAYSWEEP_WITH_ITK=ON (" +
                      function().problem + ")");
    const ItkFormats& formats = *reinterpret_cast<const ItkFormats* (*)()>(function().address)();
    if (formats.version != kItkFormatsVersion)
        throw IoError(std::string("cannot ") + what + " '" + path +
                      "': the module 'raysweep_medical.so' belongs to another build; build or install it again");
    return formats;
}

}  // namespace

bool hasItk() {
    return function().address != nullptr;
}

StoredVolume readItkVolume(const std::string& path, ItkFormat format, const ProgressCallback& progress) {
    return formatsFor(path).volume(path, format, progress);
}

StoredVolume readDicomSeries(const std::vector<std::string>& files, const std::string& series, bool positions,
                             const ProgressCallback& progress) {
    return formatsFor(files.front()).series(files, series, positions, progress);
}

void writeMetaImage(const std::string& path, const Index3& dims, const float* samples, const Vec3& origin,
                    const Vec3& spacing) {
    formatsFor(path, "write").write(path, dims, samples, origin, spacing);
}

}  // namespace raysweep
