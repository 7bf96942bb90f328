/// How well photographs have seen the voxels of a volume.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/progress.h"
#include "raysweep/volume/grids.h"

#include <vector>

namespace raysweep {

struct PhotoConfidenceOptions {
    double seen = 0.05;       ///< part of a ray's light that a voxel must give to count as seen, in (0,1]
    int samplesPerSlice = 2;  ///< of rays, from slice to slice, 1 to 16

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

struct PhotoConfidence {
    openvdb::FloatGrid::Ptr confidence;  ///< "confidence", in [0,1]; null if `progress` asked to stop
    openvdb::FloatGrid::Ptr views;       ///< "views": a whole number; null likewise
};

/// Of a ray's colour (composite.h, eq. 1 and 2) voxel j makes up the part
///
///     P_j = ∂C/∂c_j = Σ_i T_i (1 − exp(−τ_i)) w_ij                                                        (1)
///
/// with T_i what comes through to sample i, and w_ij the weight with which the sample takes the voxel's colour. A
/// voxel's confidence is the largest P_j of all photographs' rays; its views are those photographs that have a ray with
/// P_j of at least `seen`. What is inside of opaque matter, or covered from all sides, has neither. Both grids have the
/// active voxels of `density`; matter that is hardly there is hardly seen, too. The same bits for any number of
/// threads.
///
/// Rays are those of the pixels; several for pixels larger than a voxel, fewer for smaller ones (photo_views.h,
/// setRays): at most 1.25 voxels apart. Memory: 28 bytes for each voxel of a brick, the
/// photographs made smaller, and the rays of one.
/// @param density extinction, 1/world unit; its voxels are cubes along the world's axes
/// @throw InvalidArgument unless they are, for options out of bounds, and as requireUsable of the photographs
PhotoConfidence photoConfidence(const openvdb::FloatGrid& density, const std::vector<Photograph>& photographs,
                                const PhotoConfidenceOptions& options = {}, const ProgressCallback& progress = {});

}  // namespace raysweep
