#pragma once

#include "raysweep/scene/scene.h"

#include <string>

namespace raysweep {

/// Why an answer for `scene` is NaN or infinite, for messages: which of its quantities is farthest from 1, by powers of
/// ten, and how large that is.
std::string describeExtremes(const Scene& scene);

}  // namespace raysweep
