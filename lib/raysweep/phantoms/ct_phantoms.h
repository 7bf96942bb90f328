/// The volumes that tomography is tried on: Shepp and Logan's head, and a box with holes.
#pragma once

#include "raysweep/phantoms/phantom.h"
#include "raysweep/phantoms/solid_shapes.h"

#include <vector>

namespace raysweep {

enum class HeadContrast {
    original,  ///< skull 2, brain 1.02, details ±0.01 and ±0.02
    modified   ///< Toft's: skull 1, brain 0.2, details ±0.1 and ±0.2, so that they are seen without a window
};

/// Ten ellipsoids in the cube [-halfSize, halfSize]³, head up along y; nowhere below 0. Its largest density is that of
/// the skull. Shapes: Kak and Slaney, Principles of Computerized Tomographic Imaging (1988), section 3.3, the head in
/// three dimensions; contrast: Toft, The Radon Transform (thesis, 1996), appendix B.
std::vector<SolidShape> sheppLogan(double halfSize = 1, HeadContrast contrast = HeadContrast::modified);

/// A box of density 1 that takes up 5/8 of [-halfSize, halfSize] along each axis, with cylinders drilled through it
/// along x, y and z and with spherical holes, one of them half filled. Nothing overlaps, so densities are 0, 1/2 and 1.
/// Radii go by the box's smallest half edge, 1/20 to 3/10 of it; where holes are, by all three.
std::vector<SolidShape> boxWithHoles(const Vec3& halfSize = Vec3(1));

/// As a phantom's options say: `size` (the box with holes: or `dims`) and `voxelSize` give the grid and so the size of
/// what is in it, `density` is its largest density.
std::vector<SolidShape> sheppLogan(const PhantomOptions& options);
std::vector<SolidShape> boxWithHoles(const PhantomOptions& options);

/// The grids of these shapes. @throw InvalidArgument as PhantomOptions::validate.
openvdb::FloatGrid::Ptr makeSheppLogan(const PhantomOptions& options);
openvdb::FloatGrid::Ptr makeBoxWithHoles(const PhantomOptions& options);

}  // namespace raysweep
