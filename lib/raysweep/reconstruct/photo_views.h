/// Photographs made ready to correct the voxels of a grid.
#pragma once

#include "raysweep/camera/photographs.h"
#include "raysweep/projector/composite.h"
#include "raysweep/reconstruct/reconstruction_grid.h"

#include <array>
#include <vector>

namespace raysweep {

/// Cubic voxels that fill a box, `resolution` along its longest edge, whole bricks along the others.
ReconstructionGrid photoGrid(const Box3& box, int resolution);

/// Edge of a pixel, seen in the middle of the grid, in voxels.
double pixelEdge(const PhotoCamera& camera, const ReconstructionGrid& grid);

/// The photographs, those with pixels much smaller than voxels reduced: as often as pixels stay at most as large as
/// voxels, seen in the middle of the grid. @throw InvalidArgument for no photographs, such without alpha, and cameras
/// of other sizes than their pictures.
std::vector<Photograph> picturesFor(const std::vector<Photograph>& photographs, const ReconstructionGrid& grid);

/// The part of space that a ray stands for, along it: at sample k, `begin` + k `rate` is the root of its cross section
/// times the distance between samples, both in voxels. Sums over the rays of a picture that weigh each sample by this,
/// squared, and by interpolation, are means.
struct RayShare {
    float begin = 0, rate = 0;

    float at(float k) const {
        const float root = begin + k * rate;
        return root * root;
    }
};

/// The rays of a picture that meet bricks, in the order of their major axes.
struct PhotoRays {
    std::vector<CompositeRay> rays;
    std::vector<RayShare> shares;
    std::vector<std::array<float, 4>> pixels;  ///< what each should see: RGBA, linear light, multiplied by alpha
    double pictureRays = 0;                    ///< these, and those that meet nothing
    double missed = 0;                         ///< sum of squares of the pixels of the latter
};

/// Pixels larger than a voxel get several rays, so that no voxel is missed; of smaller ones every other has one, like
/// the fields of one colour of a board, if these are close enough.
/// @param perSlice samples from slice to slice, > 0
/// @param time odd or even: which of these
void setRays(PhotoRays& rays, const Photograph& picture, const ReconstructionGrid& grid, const CompositeLayout& layout,
             int perSlice, int time);

/// Gives the samples of a ray their parts of what a pixel shows more, such that it is met by the shortest change of
/// colours: by their visibility v_s (composite.h, eq. 2), v_s / Σ v², times the ray's share. Extinction is given
/// nothing.
void shareColors(const RayShare& share, const RaySamples& samples, SampleShare* shares);

}  // namespace raysweep
