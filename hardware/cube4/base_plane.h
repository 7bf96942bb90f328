/// The lattice of a view's rays, and the pixels of its detector: the warp between the two.
#pragma once

#include "cube4/dense_volume.h"
#include "cube4/traversal.h"

#include <vector>

namespace raysweep::cube4 {

/// Parallel rays of a picture's or a detector's pixels. World units.
struct PixelRays {
    Vec3 direction{0, 0, 1};            ///< of the rays
    Vec3 origin{0}, column{0}, row{0};  ///< centre of pixel (0,0), and from it to the next
};

/// Where the machine's rays of a view meet its detector.
class BasePlane {
  public:
    /// @param origin world position of the centre of voxel `box.low`  @param pad empty voxels around the box in memory
    /// @param content the voxels that passes go through
    /// @param depth in slices, behind the first one: where the lattice's rays are to be those of pixels
    /// @throw InvalidArgument for rays that run along the detector
    BasePlane(const PixelRays& pixels, const DenseBox& box, const Vec3& origin, int pad, const ContentBox& content,
              double depth = 0);

    /// The front whose lattice has a ray at the first pixel.
    const Direction& direction() const { return direction_; }

    /// Pixel coordinates (column, row) of the ray at position (u,v) of slice k of a pass; whole numbers where they are
    /// off by next to nothing.
    Imath::V2d pixelOf(const Traversal& traversal, double u, double v, double k) const;

    /// Position (u, v) in slice k of a pass of the ray of a pixel.
    Imath::V2d positionOf(const Traversal& traversal, double column, double row, double k) const;

  private:
    Direction direction_;
    Matrix3 pixelFromMemory_, memoryFromPixel_;  ///< of differences; the third coordinate is along the rays
    Vec3 originInMemory_;                        ///< of pixel (0,0)
};

/// `value`, or the whole number that it is off by next to nothing.
double snapped(double value);

/// Bilinear interpolation in a picture; NaN outside, and where a pixel that counts is NaN.
float sampleOf(const std::vector<float>& values, int width, int height, const Imath::V2d& at);

}  // namespace raysweep::cube4
