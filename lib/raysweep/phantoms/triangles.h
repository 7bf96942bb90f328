/// Translucent coloured triangles, the volume that reconstruction from photographs is tried on (Dachille, Mueller,
/// Kaufman 2000, figures 4 and 11).
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/color_volume.h"

#include <cstdint>
#include <vector>

namespace raysweep {

/// A thin sheet: the prism that reaches half the thickness beyond the triangle to both sides.
struct TranslucentTriangle {
    Vec3 corners[3];     ///< world units
    double opacity = 0;  ///< of a voxel that it fills, for light that crosses one voxel edge, in (0,1)
    Color color;         ///< linear
};

struct TrianglesOptions {
    int size = 128;        ///< edge of the cube of voxels, in [8,2048]
    double voxelSize = 0;  ///< edge of a voxel, world units; 0: such that the cube's is 2 units
    int count = 150;       ///< triangles, in [1,100000]
    double thickness = 1;  ///< of a sheet, voxels, in [0.1,8]
    bool binary = false;   ///< a voxel is full of a triangle if its centre is in the sheet, else empty
    std::uint32_t seed = 1;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Triangles inside the cube: centres of balls spread evenly, radii evenly in [0.18,0.4] of the cube's edge, corners
/// evenly in the ball; opacity evenly in [0.05,0.95], colours evenly in [0,1]³. One that would come out of the cube is
/// drawn anew. The same on every machine.
std::vector<TranslucentTriangle> randomTriangles(const TrianglesOptions& options);

/// Voxels (0,0,0) to size - 1, centred at the world's origin, with partial coverage: a triangle that fills the share c
/// of a voxel, exact but for rounding, adds c times the optical depth of a filled one. Optical depths of triangles add,
/// and colours are weighted by them. The same bits for any number of threads.
/// @throw InvalidArgument as TrianglesOptions::validate, and for triangles without area or opacity in (0,1).
ColorVolume voxelizeTriangles(const std::vector<TranslucentTriangle>& triangles, const TrianglesOptions& options);

/// Both. @throw InvalidArgument as TrianglesOptions::validate.
ColorVolume makeTriangles(const TrianglesOptions& options);

}  // namespace raysweep
