/// Something like a cast engine: where the engine's scan is not at hand, the engine room shows this.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <vector>

namespace raysweep {

/// A box along the axes, or a round bar. Numbers are in edges of the whole's box: x and y in its width, z in its
/// height; radii in its width.
struct EnginePart {
    int axis = -1;         ///< of the bar; -1: a box
    Vec3 low{0}, high{0};  ///< corners of the box; of a bar only its two ends along `axis` count
    Vec3 centre{0};        ///< a point on the bar's axis
    double radius = 0;
    float value = 0;  ///< density; 0 cuts away
};

/// The block, its flange, four lined bores open at the top, a recess with ribs in its right side, ports on its left,
/// and the tunnel of the crankshaft below: boxes and bars, each painted over those before it.
std::vector<EnginePart> engineParts();

/// The block in the voxels (0,0,0) to `box` - 1, standing on the first slice; densities in [0,1]. A voxel that a part
/// fills in part has that part of its density: exact for boxes, for bars within a voxel's width of their surface as if
/// that were flat and perpendicular to the radius.
/// @param box voxels along x, y (the same) and z, at least 8 each
openvdb::FloatGrid::Ptr makeEngineBlock(const openvdb::Coord& box);

}  // namespace raysweep
