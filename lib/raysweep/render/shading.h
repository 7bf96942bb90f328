/// Colours as they look under a distant light: ambient and diffuse reflection, without shadows.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// c = colour (ambient + diffuse max(0, -light.n)): Lambert's law, as photographs are taken to be lit (Dachille,
/// Mueller, Kaufman 2000, section 5.2 and figure 12).
struct Shading {
    double ambient = 1;   ///< part of a colour that is seen whatever the light, in [0,1]
    double diffuse = 0;   ///< part that is seen where light falls straight on a surface, in [0,1]; both at most 1
    Vec3 light{0, 1, 0};  ///< direction in which the light travels, world space, any length but 0

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// n = -grad alpha / |grad alpha|, world space, at the active voxels of `shape`: central differences over one voxel
/// each way of the opacity of voxels, alpha = 1 - exp(-extinction h). 0 where opacity is flat: there is no surface.
/// @param density times `extinctionScale` is extinction, 1/world unit; 0 where inactive
/// @param shape FloatGrid or Vec3SGrid with the transform of `density`, which is linear
/// @throw InvalidArgument for other grids
openvdb::Vec3SGrid::Ptr surfaceNormals(const openvdb::FloatGrid& density, double extinctionScale,
                                       const openvdb::GridBase& shape);

/// `color` as it looks under `shading`; what has no normal looks as if it faced the light.
/// @param color FloatGrid or Vec3SGrid  @param normals of surfaceNormals for `color`
/// @throw InvalidArgument as Shading::validate, and for other grids
openvdb::GridBase::Ptr shaded(const openvdb::GridBase& color, const openvdb::Vec3SGrid& normals,
                              const Shading& shading);

}  // namespace raysweep
