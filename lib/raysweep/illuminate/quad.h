/// Area lights as voxels.
#pragma once

#include "raysweep/scene/light.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// World area of the quad in each voxel it passes; the values sum to its whole area. Active where it is.
/// @throw InvalidArgument for a quad of more than 1e7 voxels
openvdb::FloatGrid::Ptr rasterizeQuad(const QuadLight& quad, const openvdb::math::Transform& transform);

}  // namespace raysweep
