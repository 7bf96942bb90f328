/// In which order views correct a volume. Views that follow each other should see it from directions at right angles:
/// then one undoes least of what the other did.
#pragma once

#include "raysweep/camera/projection_geometry.h"

#include <cstdint>
#include <vector>

namespace raysweep {

enum class ViewOrder {
    golden,     ///< each view lies about a golden section of a half turn (111°) from the one before
    random,     ///< shuffled, anew for each pass
    sequential  ///< as they come
};

/// The views of pass `pass` (0, 1, ...), each once. `golden` and `sequential` are the same in every pass; `golden`
/// takes the angles between the views' middle rays, so gaps and turns of any length are fine.
std::vector<int> viewOrder(const ProjectionGeometry& geometry, ViewOrder order, std::uint32_t seed, int pass);

}  // namespace raysweep
