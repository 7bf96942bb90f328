/// What readers of JPEG pictures pass over.
#pragma once

#include <string>

namespace raysweep {

/// True for a JPEG that ends before its end mark. Readers fill up what is missing with grey, and say nothing.
bool isCutJpeg(const std::string& path);

}  // namespace raysweep
