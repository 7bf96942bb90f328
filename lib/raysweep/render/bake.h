/// Radiosity of a lit volume on exact surfaces: the radiosity is a 3-D texture for them (Dachille, Mueller, Kaufman
/// 2000, section 4).
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/image/image.h"
#include "raysweep/mesh/triangle_mesh.h"
#include "raysweep/render/render.h"

namespace raysweep {

/// Numbers of places.
struct BakeCounts {
    std::size_t places = 0;
    std::size_t turned = 0;  ///< where the volume lies before the surface and not behind it: seen from the other side
    std::size_t missed = 0;  ///< where there is next to nothing of the volume: black
};

struct BakedMesh {
    TriangleMesh mesh;  ///< with radiosity as its colours, W/m^2/sr; all of a shell's triangles face alike
    BakeCounts corners;
    Image atlas;  ///< RGB, empty unless asked for
    BakeCounts texels;
    bool complete = true;  ///< false if stopped by the progress callback
};

struct BakeOptions {
    int atlas = 0;  ///< side of a square picture that the mesh's texture coordinates reach into, pixels; 0: none

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// What an eye close to the surface sees that looks at it along its normal: source radiance weighted with the opacity
/// that it has on the way from 1.5 voxels outside to 2 voxels inside,
///
///     B = integral of S sigma T ds / integral of sigma T ds,
///
/// so that the picture is that of `render` whatever part of a voxel the surface covers. Normals are cornerNormals.
/// In the atlas row 0 is v = 1; texels that no triangle covers take the mean of those beside them, four texels far, so
/// that interpolation at seams finds no black.
/// @throw InvalidArgument for options out of range, what RenderInput::validate refuses, and an atlas without texture
/// coordinates
BakedMesh bakeRadiosity(const RenderInput& volume, const TriangleMesh& mesh, const BakeOptions& options = {},
                        const ProgressCallback& progress = {});

}  // namespace raysweep
