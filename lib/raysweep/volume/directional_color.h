/// Colours that depend on where they are seen from.
#pragma once

#include "raysweep/camera/photo_camera.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// Spherical harmonics of degree 0 and 1 in their plain form, without the basis' constants: along a direction d of
/// length 1, in which one looks, matter has the colour
///
///     c(d) = max(0, c₀ + d_x c_x + d_y c_y + d_z c_z)   for each of red, green and blue, linear light (1)
///
/// The grids share one transform and are 0 where inactive.
struct DirectionalColor {
    openvdb::Vec3SGrid::Ptr constant;  ///< "Cd_0": c₀; null: colours are the same from all sides
    openvdb::Vec3SGrid::Ptr x, y, z;   ///< "Cd_x", "Cd_y", "Cd_z": world axes
};

/// The colours that a camera sees: of each voxel that along the ray to its centre.
openvdb::Vec3SGrid::Ptr colorSeenFrom(const DirectionalColor& color, const PhotoCamera& camera);

}  // namespace raysweep
