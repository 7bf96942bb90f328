/// A volume from photographs as something that light falls on.
#pragma once

#include "raysweep/camera/photographs.h"
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

/// The light of a view that goes along with the camera; `shading` is as for the camera `first`.
ViewLight lightOf(const Shading& shading, const PhotoCamera& camera, const PhotoCamera& first);

/// `colors` in a light: those of the surfaces, or others in their place.
void lightAll(const PhotoSurfaces& surfaces, const std::vector<CompositeVoxel>& colors, const ViewLight& light,
              std::vector<CompositeVoxel>& shown);

inline Vec3 unpacked(const PackedNormal& n) {
    return Vec3(n.x, n.y, n.z) / 32767.0;
}

}  // namespace raysweep
