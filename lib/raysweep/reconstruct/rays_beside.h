/// A grid that is smaller than the object. Iterative methods explain all that a ray measures by the voxels that it
/// meets: what lies beyond the grid is put into it, mostly at its faces. How much that may be, rays tell that do not
/// meet it.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/camera/projections.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

#include <optional>
#include <string>

namespace raysweep {

/// Rays that see the object: that measure more than a twentieth of the largest line integral.
struct RaysBeside {
    double share = 0;  ///< of these, those that run beside the grid
    double mean = 0;   ///< of the line integrals that those measure, relative to the largest

    /// In words.
    std::string warning() const;
};

/// Nothing if less than a hundredth of the rays that see the object run beside the grid. Where all rays are at right
/// angles to an axis of the grid, those that pass it at the ends of that axis are not counted: slices do not know of
/// each other then. Of about two million rays, evenly some.
std::optional<RaysBeside> findRaysBeside(const Projections& projections, const ProjectionGeometry& geometry,
                                         const ReconstructionGrid& grid);

}  // namespace raysweep
