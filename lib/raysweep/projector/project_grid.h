/// Simulated X-rays.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/camera/projections.h"
#include "raysweep/core/progress.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// The line integral of `grid` along every ray of `geometry`, by Joseph's weights (joseph.h, eq. 1). Active tiles count
/// as their voxels; without unit if the grid is an extinction in 1/world unit. The grid may be turned, and its voxels
/// be of different edges. If `progress` says stop, views from there on are NaN.
/// @throw InvalidArgument as ProjectionGeometry::validate, for an empty grid, a transform that is not linear or is
/// singular, and where the detector misses the volume in every view.
Projections projectGrid(const openvdb::FloatGrid& grid, const ProjectionGeometry& geometry,
                        const ProgressCallback& progress = {});

}  // namespace raysweep
