/// What passes between the library and the module `raysweep_medical`, which holds ITK and what it stands on: some 35
/// shared libraries, loaded when a file needs them.
#pragma once

#include "raysweep/formats/itk_volume.h"

namespace raysweep {

/// To be counted up whenever something that passes changes.
constexpr int kItkFormatsVersion = 4;
struct ItkFormats {
    int version;
    StoredVolume (*series)(const std::vector<std::string>& files, const SeriesRequest& request,
                           const ProgressCallback& progress);
    void (*write)(const std::string& path, const Index3& dims, const float* samples, const Vec3& origin,
                  const Vec3& spacing);
};

// In the module: see readDicomSeries and writeMetaImage. Under names of their own, for which nothing can
// stand in.
StoredVolume itkSeries(const std::vector<std::string>& files, const SeriesRequest& request,
                       const ProgressCallback& progress);
/// To a file that is there and empty. @throw IoError, which does not name it
void itkWrite(const std::string& path, const Index3& dims, const float* samples, const Vec3& origin,
              const Vec3& spacing);

}  // namespace raysweep
