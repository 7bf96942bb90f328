/// Volumes that have opacity and colour of their own, as photographs show them: no light is computed in them.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/directional_color.h"
#include "raysweep/volume/vdb_io.h"

namespace raysweep {

/// Matter and its colour. The grids share one linear transform and are 0 where inactive.
struct ColorVolume {
    openvdb::FloatGrid::Ptr density;  ///< "density": extinction, 1/world unit
    openvdb::Vec3SGrid::Ptr color;    ///< "Cd": linear RGB, not multiplied by opacity; reaches one voxel beyond
                                      ///< `density`, or interpolation mixes edges with black
    openvdb::FloatGrid::Ptr confidence = nullptr;  ///< "confidence": how well photographs have seen a voxel, in [0,1];
                                                   ///< may be null
    openvdb::FloatGrid::Ptr views = nullptr;       ///< "views": how many photographs have; may be null
    DirectionalColor directional = {};             ///< of which `color` is a mean; may be empty
};

/// Opacity of a voxel, 1 - exp(-extinction h), for light that crosses one voxel edge h (units.md): "opacity", active
/// where `density` is. @param density extinction, 1/world unit
openvdb::FloatGrid::Ptr opacityGrid(const openvdb::FloatGrid& density);

/// `color`, which is known in the active voxels of `density`, continued by one voxel to all sides: there it is the mean
/// of those of the 26 neighbours that are active, weighted by density. Elsewhere inactive and 0.
openvdb::Vec3SGrid::Ptr extendedColor(const openvdb::Vec3SGrid& color, const openvdb::FloatGrid& density);

/// The grids of a file: density, opacity, Cd, and confidence, views and directional colours if there are such. Metadata
/// of Cd say, as those of a lit file's radiosity, of which grid and of which extinction per unit density (1) it is the
/// colour.
openvdb::GridPtrVec gridsOf(const ColorVolume& volume);

/// Sums of squares over all voxels.
struct ColorPower {
    double opacity = 0;
    double color = 0;  ///< of opacity times colour, mean over its three channels

    void operator+=(const ColorPower& other) { opacity += other.opacity, color += other.color; }
};

ColorPower powerOf(const ColorVolume& volume);

/// The colour grid of a file: a vec3s grid called "Cd"; null if there is none.
openvdb::Vec3SGrid::Ptr colorGrid(const VdbFile& file);

}  // namespace raysweep
