/// Which way the matter of a volume from photographs faces, where it is no thicker than a few voxels. The gradient of a
/// single voxel's opacity changes its sign within such a sheet and is mostly noise there; the axis along which opacity
/// changes around it is not: the eigenvector of the largest eigenvalue of the structure tensor, the mean of g gᵀ over
/// neighbours (J. Bigün and G. H. Granlund, ICCV 1987).
#pragma once

#include "raysweep/projector/composite_volume.h"

#include <vector>

namespace raysweep {

/// The axis, and on which side of the sheet a voxel lies.
struct SheetNormal {
    float axis[3] = {0, 0, 0};  ///< length 1, either sign; 0 where there is nothing
    float side = 0;             ///< of the voxel's own gradient the part along `axis`, in [-1,1]: > 0 outside along it
};

/// Of all voxels.
std::vector<SheetNormal> sheetNormals(const CompositeLayout& layout, const std::vector<CompositeVoxel>& voxels);

/// What falls on sheets in one view, and how they return it. With x = axis.toLight and y = axis.toCamera
///
///     brightness = ambient + diffuse (|x| / 2 + (side of the voxel) x / 2 + kTilt x y) (1)
///
/// Where only one side is seen that is Lambert's law, but for the last term: the surface of voxels is rough, and of
/// what is rough the parts that face the camera hide others.
struct SheetLight {
    float ambient = 1, diffuse = 0;
    float toLight[3] = {0, 0, 0}, toCamera[3] = {0, 0, 0};  ///< length 1
};

/// Of the normals' tilt towards the camera: what suits pictures of voxels whose normals are central differences. Lights
/// that are found move away from the camera by some 5 degrees for 0.1.
constexpr float kTilt = 0.1f;

/// The brightness of eq. 1, and what changes it.
struct SheetBrightness {
    float all;      ///< eq. 1
    float diffuse;  ///< derivative with respect to it
    float along;    ///< `along` times axis is that with respect to `toLight`

    SheetBrightness(const SheetNormal& n, const SheetLight& light) {
        const float x = dot(n, light.toLight), tilt = kTilt * dot(n, light.toCamera);
        const float slope = 0.5f * ((x < 0 ? -1.0f : 1.0f) + n.side) + tilt;
        diffuse = slope * x;
        along = light.diffuse * slope;
        all = light.ambient + light.diffuse * diffuse;
    }

  private:
    static float dot(const SheetNormal& n, const float* v) {
        return n.axis[0] * v[0] + n.axis[1] * v[1] + n.axis[2] * v[2];
    }
};

}  // namespace raysweep
