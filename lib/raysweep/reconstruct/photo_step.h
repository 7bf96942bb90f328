/// What voxels of a brick are corrected by, and how they look under a light (photo_sart.h).
#pragma once

#include "raysweep/projector/composite_volume.h"

#include <cstddef>
#include <cstdint>

namespace raysweep {

/// Length 1, times 32767; all 0 where there is none.
struct PackedNormal {
    std::int16_t x = 0, y = 0, z = 0, unused = 0;

    bool isSurface() const { return (x | y | z) != 0; }
};

/// The light of one view: brightness is ambient + diffuse max(0, toLight.n).
struct ViewLight {
    float ambient = 1, diffuse = 0;
    float toLight[3] = {0, 0, 0};  ///< length 1
};

struct PhotoStep {
    float relaxation = 1;
    float least = 0;            ///< multiplicative: added to opacity
    float mostExtinction = 10;  ///< 1 / edge of a voxel
};

/// Multiplicative: extinction is changed by (opacity + `least`) times its sum, and colour by the sum times the
/// voxel's brightness. Clears the sums.
/// @param normals null without diffuse light
void multiplyBrick(CompositeVoxel* voxels, CompositeVoxel* sums, const VoxelMask& mask, const PackedNormal* normals,
                   const ViewLight& light, const PhotoStep& step);

/// Additive: `matter` is opacity and opacity times colour, all in [0,1]; to them the sums are added. Clears the sums.
void addToBrick(CompositeVoxel* matter, CompositeVoxel* sums, const VoxelMask& mask, const PhotoStep& step);

/// Extinction and colour of voxels that are given as opacity and opacity times colour.
void straightenBrick(const CompositeVoxel* matter, CompositeVoxel* voxels, const PhotoStep& step);

/// -grad opacity / its length, by central differences over one voxel each way.
void brickNormals(const CompositeLayout& layout, const CompositeVoxel* voxels, std::size_t brick,
                  PackedNormal* normals);

/// Brightness of a surface; one that has no normal looks as if it faced the light.
inline float brightness(const ViewLight& light, const PackedNormal& n) {
    constexpr float kUnit = 1.0f / 32767;
    if (!n.isSurface()) return light.ambient + light.diffuse;
    const float facing =
        kUnit * (float(n.x) * light.toLight[0] + float(n.y) * light.toLight[1] + float(n.z) * light.toLight[2]);
    return light.ambient + light.diffuse * (facing > 0 ? facing : 0.0f);
}

/// Colours times brightness. @param normals null without diffuse light  @param shown may be `voxels`
void lightBrick(const CompositeVoxel* voxels, const PackedNormal* normals, const ViewLight& light,
                CompositeVoxel* shown);

}  // namespace raysweep
