/// The lattice of a view's rays, and the pixels of its detector: the warp between the two.
#pragma once

#include "cube4/dense_volume.h"
#include "cube4/reconstruction.h"
#include "cube4/traversal.h"

namespace raysweep::cube4 {

/// Where the machine's rays of a view meet its detector.
class BasePlane {
  public:
    /// @param origin world position of the centre of voxel `box.low`  @param pad empty voxels around the box in memory
    /// @throw InvalidArgument for rays that run along the detector
    BasePlane(const MeasuredView& view, const DenseBox& box, const Vec3& origin, int pad);

    /// The front whose lattice has a ray at the first pixel.
    const Direction& direction() const { return direction_; }

    /// Pixel coordinates (column, row) of the ray at position (u,v) of slice k of a pass; whole numbers where they are
    /// off by next to nothing.
    Imath::V2d pixelOf(const Traversal& traversal, double u, double v, int k) const;

    /// Position (u, v) in slice k of a pass of the ray of a pixel.
    Imath::V2d positionOf(const Traversal& traversal, double column, double row, int k) const;

  private:
    Direction direction_;
    Matrix3 pixelFromMemory_, memoryFromPixel_;  ///< of differences; the third coordinate is along the rays
    Vec3 originInMemory_;                        ///< of pixel (0,0)
};

/// Bilinear interpolation in a picture; NaN outside, and where a pixel that counts is NaN.
float sampleOf(const std::vector<float>& values, int width, int height, const Imath::V2d& at);

}  // namespace raysweep::cube4
