/// Where a volume is reconstructed.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// Cubic voxels along the world's axes; the first has the index (0,0,0).
struct ReconstructionGrid {
    Index3 dims{0};      ///< voxels along x, y, z, > 0
    Vec3 center{0};      ///< middle of the grid, world units
    double spacing = 0;  ///< edge of a voxel, world units, > 0

    /// Centre of voxel (i,j,k); need not be whole numbers.
    Vec3 voxel(double i, double j, double k) const {
        return center + Vec3(i - 0.5 * (dims.x - 1), j - 0.5 * (dims.y - 1), k - 0.5 * (dims.z - 1)) * spacing;
    }

    /// Index to world space.
    openvdb::math::Transform::Ptr transform() const;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// All that the detector sees of an object that turns: about the part of the axis that is seen, as wide as the rays at
/// the detector's sides are away from the axis in any view; voxels as large as the smaller edge of a pixel is at the
/// axis. @throw InvalidArgument if the views are not those of a turn about an axis, as fitOrbit, or if more than 16384
/// voxels along an axis were needed.
ReconstructionGrid coveringGrid(const ProjectionGeometry& geometry);

}  // namespace raysweep
