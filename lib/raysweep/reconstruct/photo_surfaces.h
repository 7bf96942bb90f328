/// A volume from photographs as surfaces that light falls on.
#pragma once

#include "raysweep/projector/composite_volume.h"
#include "raysweep/reconstruct/photo_result.h"
#include "raysweep/reconstruct/photo_step.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

#include <vector>

namespace raysweep {

/// Extinction, colours and normals in bricks.
struct PhotoSurfaces {
    ReconstructionGrid grid;
    CompositeLayout layout;
    std::vector<CompositeVoxel> voxels;
    std::vector<PackedNormal> normals;
};

/// @param volume on the voxels of `grid`
PhotoSurfaces surfacesOf(const PhotoReconstruction& volume, const ReconstructionGrid& grid);

inline Vec3 unpacked(const PackedNormal& n) {
    return Vec3(n.x, n.y, n.z) / 32767.0;
}

}  // namespace raysweep
