/// What a detector without noise would measure of a phantom.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/camera/projections.h"
#include "raysweep/phantoms/solid_shapes.h"

#include <vector>

namespace raysweep {

/// The exact line integral of every pixel's ray: one ray through its centre. Rays of a cone begin at the source, those
/// of a parallel beam far away; neither ends at the detector, which may stand on the axis.
/// @throw InvalidArgument as ProjectionGeometry::validate.
Projections exactProjections(const std::vector<SolidShape>& shapes, const ProjectionGeometry& geometry);

}  // namespace raysweep
