/// What ITK does not check of NIfTI files. Nothing but itk_volume.cpp includes it.
#pragma once

#include <string>

namespace raysweep {

/// @throw IoError if `path` is not NIfTI-1, if its header is malformed, or if its data end too early.
void checkNifti(const std::string& path);

}  // namespace raysweep
