// What itk_volume.h promises, by the module that holds ITK.
#include "raysweep/core/error.h"
#include "raysweep/core/module.h"
#include "raysweep/core/output_file.h"
#include "raysweep/core/run_outputs.h"
#include "raysweep/formats/itk_formats.h"

#include <cmath>

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
                      "': this build of Raysweep has no ITK, which reads DICOM and writes MetaImage; install "
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

StoredVolume readDicomSeries(const std::vector<std::string>& files, const SeriesRequest& request,
                             const ProgressCallback& progress) {
    for (const std::string& file : files) noteInput(file);
    return formatsFor(files.front()).series(files, request, progress);
}

void writeMetaImage(const std::string& path, const Index3& dims, const float* samples, const Vec3& origin,
                    const Vec3& spacing) {
    const ItkFormats& formats = formatsFor(path, "write");
    for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(origin[axis]) || !std::isfinite(spacing[axis]) || spacing[axis] == 0)
            throw InvalidArgument("cannot write '" + path + "': origin and spacing must be finite, and no spacing 0");
    OutputFile file(path);
    try {
        formats.write(file.temporary(), dims, samples, origin, spacing);
    } catch (const IoError& e) {
        throw IoError("cannot write '" + path + "': " + e.what());
    }
    file.commit();
}

}  // namespace raysweep
