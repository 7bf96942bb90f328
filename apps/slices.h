/// A look into a volume.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/image/image.h"
#include "raysweep/volume/grids.h"

namespace raysweep::apps {

/// The slices through the middle of voxels [0, dims), across z, y and x, side by side: x or y to the right, y or z up.
/// Thin volumes are shown across z only.
/// Grey rises evenly, as seen on a display, from 0 (or the smallest value, if that is less) to the largest one.
Image middleSlices(const openvdb::FloatGrid& grid, const Index3& dims);

}  // namespace raysweep::apps
