/// What an NRRD header says of the axes. For nrrd_volume.cpp.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/formats/declared_samples.h"
#include "raysweep/formats/nrrd_header.h"
#include "raysweep/formats/volume_choice.h"

#include <array>
#include <string>
#include <vector>

namespace raysweep {

struct NrrdAxes {
    std::vector<DeclaredAxis> axes;
    Vec3 origin{0};             ///< of the first sample
    std::array<Vec3, 3> steps;  ///< along the axes of space
    std::string unit;
};

/// @throw IoError for fields that are malformed or contradict each other. @throw InvalidArgument where several channels
/// or volumes are there and none is chosen, or places cannot be used.
NrrdAxes nrrdAxes(const NrrdHeader& header, const std::string& path, const VolumeChoice& choice);

}  // namespace raysweep
