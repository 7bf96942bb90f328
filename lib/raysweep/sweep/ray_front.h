/// A front of parallel rays that steps through a volume slice by slice.
///
/// Rays form a lattice of one ray per voxel of a slice. From slice to slice all of them move sideways by the same
/// slope, so ray (u,v) is at voxel coordinates (u + offset + k*slope) in the k-th slice, and the whole front is
/// described by two shifts per slice. Lateral coordinates of rays and voxels are in voxels; k counts slices in the
/// order of travel.
#pragma once

#include "raysweep/sweep/axis.h"
#include "raysweep/volume/bricks.h"

#include <array>
#include <cstdint>

namespace raysweep {

/// Which of the lateral borders are joined to the opposite one; by axis (x, y, z).
using Periodic = std::array<bool, 3>;

/// One lateral coordinate of the front.
struct Lateral {
    double slope = 0;       ///< voxels per slice, in [-1,1]
    double offset = 0;      ///< in [0,1)
    int low = 0, high = 0;  ///< voxels of the volume, high exclusive
    bool periodic = false;

    double position(int k) const { return offset + k * slope; }
    int shift(int k) const { return int(std::floor(position(k))); }
    int size() const { return high - low; }
};

struct RayFront {
    SweepAxis axis;
    bool ascending = true;    ///< slices in ascending order of the major coordinate
    int firstSlice = 0;       ///< major coordinate of the first slice met
    int slices = 0;           ///< number of slices of the volume
    Lateral column, row;      ///< u and v
    double stepLength = 0;    ///< world length of a ray in a slice
    double crossSection = 0;  ///< world area per ray, perpendicular to the direction
    int reach = 0;            ///< voxels met beyond the one at the shift: 0 nearest, 1 linear

    /// Slice number in the order of travel of the slice of `brickLow` (low corner) that is met first.
    int firstStep(int brickLow) const {
        return ascending ? brickLow - firstSlice : firstSlice - (brickLow + kBrickEdge - 1);
    }
};

/// The front for light that travels along `direction` (unit, world). `offsetColumn` and `offsetRow` in [0,1) place the
/// lattice of rays: a fresh random pair in each sweep makes `nearest` unbiased.
RayFront parallelFront(const BrickLayout& layout, const Vec3& direction, int reach, double offsetColumn,
                       double offsetRow, const Periodic& periodic);

/// Half-open range of ray coordinates.
struct RayRange {
    int begin = 0, end = 0;
    bool empty() const { return end <= begin; }
    int size() const { return empty() ? 0 : end - begin; }
};

/// Rays of lattice row `row` that enter the volume somewhere.
RayRange raysThatEnter(const RayFront& front, int row);

/// Number of rays that enter the volume.
double countRaysThatEnter(const RayFront& front);

/// All ray coordinates that occur along one lateral axis.
RayRange rayExtent(const RayFront& front, const Lateral& lateral);

}  // namespace raysweep
