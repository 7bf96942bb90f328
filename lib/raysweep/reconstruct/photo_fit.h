/// A volume from photographs: extinction and colour such that compositing them along the pixels' rays (composite.h)
/// gives what the pictures show. The exact derivative of the squared difference lowers it, by steps of Adam
/// (voxel_fit.h); only what lies in the visual hull is kept; from coarse to fine. As S. Fridovich-Keil, A. Yu and
/// others, "Plenoxels: Radiance Fields without Neural Networks", CVPR 2022, do, but mixed in linear light, as renderers
/// mix volumes.
///
/// With colours that depend on the direction each update has rays of one photograph (photo_directional.h); `color` is
/// then the mean of what the photographs see of a voxel, weighed by how much that is of what they see.
///
/// Colours are compared as displays encode them and as pictures with alpha are put on a backdrop: with straight colour
/// C / α and α = 1 - T, P = encode(C / α) α. Before every backdrop b of equal right, the mean of the squared difference
/// of P + (1 - α) b is
///
///     E = (ΔP - Δα / 2)² + Δα² / 12   summed over red, green and blue                                          (1)
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/core/progress.h"
#include "raysweep/reconstruct/photo_result.h"
#include "raysweep/volume/color_volume.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace raysweep {

struct PhotoFitOptions {
    int resolution = 256;              ///< voxels along the longest edge of the box, multiple of 8, 16 to 1024
    std::optional<Box3> box;           ///< of the volume, world units; without it what the photographs show
    int levels = 3;                    ///< grids, each twice as fine as the one before, > 0
    double coarsePasses = 1.5;         ///< how often each pixel is used in each coarse grid, > 0
    double passes = 5;                 ///< and in the finest, > 0
    int pictureSize = 400;             ///< pictures whose longer edge is twice this or more are reduced, pixels, > 0
    int samplesPerSlice = 2;           ///< of rays, from slice to slice, > 0
    int raysPerUpdate = 16384;         ///< > 0
    double extinctionRate = 0.1;       ///< first step of extinction, 1/edge of a voxel, > 0
    double colorRate = 0.02;           ///< first step of the square root of colours, > 0
    double lastRate = 0.1;             ///< part of the rates that is left at the end of a grid, in (0,1]
    double smoothness = 3e-3;          ///< weight of the total variation of extinction and of colour, >= 0
    bool adaptSmoothness = true;       ///< that is where it begins; then it follows from the pixels that are left out
    int sh = 0;                        ///< degree of the spherical harmonics that colours have of the direction from
                                       ///< which they are seen (volume/directional_color.h): 0 (none) or 1
    double slopeRate = 0.01;           ///< first step of their coefficients, as differences of roots of colours, > 0
    double smoothSlopes = 3e-2;        ///< weight of the coefficients' total variation, >= 0
    double pullSlopes = 3e-2;          ///< weight of what pulls them to 0, >= 0
    double sparsity = 1e-3;            ///< weight of log(1 + 2 extinction²), >= 0
    double backdrop = 0.5;             ///< mean of the backdrops that pictures are compared on, in [0,1]
    double backdropSpread = 1.0 / 12;  ///< their variance, > 0
    double hullThreshold = 0.02;       ///< alpha above which a pixel shows something, in [0,1)
    double prune = 0.01;       ///< extinction below which a coarse voxel without others around it is dropped, >= 0
    double leftOut = 0.02;     ///< part of the pixels that is not fitted but compared with, in [0,0.5); with none
                               ///< smoothness stays
    bool refinePoses = false;  ///< cameras are moved to where they fit the others (pose_refine.h), by all grids but the
                               ///< finest
    std::uint32_t seed = 1;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// Memory: 64 bytes for each voxel of a brick of the hull, 224 if colours depend on the direction, and the pictures at
/// `pictureSize`. The same bits for any number of threads.
/// @param reference of which the last point of the history tells the RMS difference, if the grid that is reached has
/// its voxels; may be null
/// @throw InvalidArgument for options out of bounds, photographs without alpha, cameras of other sizes than their
/// pictures, photographs that show nothing, and a volume that will not have room in memory.
PhotoReconstruction fitPhotographs(const std::vector<Photograph>& photographs, const PhotoFitOptions& options,
                                   const ColorVolume* reference = nullptr, const ProgressCallback& progress = {});

}  // namespace raysweep
