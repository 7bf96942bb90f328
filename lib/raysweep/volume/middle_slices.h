/// A look into a volume, as a picture.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/image/image.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// The slices through the middle of voxels [0, dims), across z, y and x, side by side with black between them: x or y
/// to the right, y or z up. A voxel's shortest edge is a pixel, its others in proportion, up to 16 pixels. What is
/// thinner than 8 voxels along z is shown across z only. Grey (three channels that are the same) rises evenly, as seen
/// on a display, from 0, or the smallest value shown if that is less, to the largest one shown. @throw InvalidArgument
/// unless dims are at least 1
Image middleSlices(const openvdb::FloatGrid& grid, const Index3& dims);

}  // namespace raysweep
