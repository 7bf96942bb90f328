/// How rays and voxels meet.
#pragma once

namespace raysweep {

enum class Interpolation {
    nearest,  ///< a ray meets one voxel per slice; the front is shifted by a fresh random offset in each sweep
    linear    ///< a ray meets the 2x2 voxels around it with bilinear weights
};

}  // namespace raysweep
