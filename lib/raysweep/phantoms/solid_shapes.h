/// Bodies of constant density whose line integrals are known exactly: phantoms for tomography.
#pragma once

#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <limits>
#include <vector>

namespace raysweep {

/// An ellipsoid, a box or a cylinder: the image of the unit ball, of the cube [-1,1]³, or of the cylinder of radius 1
/// and half length 1 along z. World units.
struct SolidShape {
    enum class Kind { ellipsoid, box, cylinder };

    Kind kind = Kind::ellipsoid;
    double density = 1;  ///< added to whatever else is there; negative in holes
    Vec3 center{0};
    /// Half axes, at right angles to each other; a cylinder's length runs along the last.
    Vec3 halfAxes[3] = {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
};

/// `halfAxes`: lengths before the ellipsoid is turned about z by `degrees`, from x towards y.
SolidShape ellipsoid(double density, const Vec3& center, const Vec3& halfAxes, double degrees = 0);

SolidShape box(double density, const Vec3& center, const Vec3& halfEdges);

/// Along coordinate axis `axis` (0: x, 1: y, 2: z).
SolidShape cylinder(double density, const Vec3& center, int axis, double radius, double halfLength);

/// Sum of the densities of the shapes that `point` is in.
double densityAt(const std::vector<SolidShape>& shapes, const Vec3& point);

/// Integral of density along `origin + t direction`, t in [from, to]; `direction` has length 1. Without a range: along
/// the whole line. Exact but for rounding.
double lineIntegral(const std::vector<SolidShape>& shapes, const Vec3& origin, const Vec3& direction,
                    double from = -std::numeric_limits<double>::infinity(),
                    double to = std::numeric_limits<double>::infinity());

/// A grid "density" of `dims` cubic voxels of edge `voxelSize`, centred at the world's origin, first index (0,0,0): the
/// mean density of each voxel, where a surface crosses it by 8x8 exact integrals along z: off by up to 1/16 of the step
/// in density where a flat side runs along z, by less elsewhere. Voxels of mean 0 or less are not active, and what is
/// constant is a tile.
/// @throw InvalidArgument naming a dimension or voxel size that is not positive and finite.
openvdb::FloatGrid::Ptr voxelize(const std::vector<SolidShape>& shapes, const openvdb::Coord& dims, double voxelSize);

}  // namespace raysweep
