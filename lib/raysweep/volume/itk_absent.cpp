// Stands for itk_*.cpp in builds without ITK.
#include "raysweep/core/error.h"
#include "raysweep/volume/itk_volume.h"

namespace raysweep {
namespace {

[[noreturn]] void fail(const std::string& path) {
    throw IoError("cannot read '" + path +
                  "': this build of Raysweep has no ITK, which reads NRRD, MetaImage, NIfTI and DICOM; install "
                  "libinsighttoolkit5-dev and configure again with -DRAYSWEEP_WITH_ITK=ON");
}

}  // namespace

bool hasItk() {
    return false;
}

StoredVolume readItkVolume(const std::string& path, ItkFormat, const ProgressCallback&) {
    fail(path);
}

StoredVolume readDicomSeries(const std::vector<std::string>& files, const std::string&, bool, const ProgressCallback&) {
    fail(files.front());
}

void writeMetaImage(const std::string& path, const Index3&, const float*, const Vec3&, const Vec3&) {
    throw IoError("cannot write '" + path +
                  "': this build of Raysweep has no ITK, which writes MetaImage; write .exr pictures, or install "
                  "libinsighttoolkit5-dev and configure again with -DRAYSWEEP_WITH_ITK=ON");
}

}  // namespace raysweep
