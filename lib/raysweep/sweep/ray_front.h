/// A front of parallel rays that goes through a volume slice by slice.
///
/// Rays form a lattice of one ray per voxel of a slice. From slice to slice all of them move sideways by the same
/// slope, so ray (u,v) is at voxel coordinates (u + offset + k*slope) in the k-th slice, and the whole front is
/// described by two shifts per slice. Lateral coordinates of rays and voxels are in voxels; k counts slices in the
/// order of travel.
#pragma once

#include "raysweep/bricks/bricks.h"
#include "raysweep/sweep/axis.h"

#include <cstdint>
#include <vector>

namespace raysweep {

/// One lateral coordinate of the front.
struct Lateral {
    double slope = 0;       ///< voxels per slice, in [-1,1]
    double offset = 0;      ///< in [0,1)
    int low = 0, high = 0;  ///< voxels of the volume, high exclusive
    bool periodic = false;

    double position(int k) const { return offset + k * slope; }
    /// The floor of `position`: the same in every slice for all rays. (std::floor is a call where SSE4 is not taken for
    /// granted.)
    int shift(int k) const {
        const double at = position(k);
        const int whole = int(at);
        return whole - (at < whole);
    }
    int size() const { return high - low; }
};

struct RayFront {
    SweepAxis axis;
    int directionClass = 0;   ///< see axis.h
    bool ascending = true;    ///< slices in ascending order of the major coordinate
    int firstSlice = 0;       ///< major coordinate of the first slice met
    int slices = 0;           ///< number of slices of the volume
    Lateral column, row;      ///< u and v
    Vec3 direction{0};        ///< of travel, unit, world
    double stepLength = 0;    ///< world length of a ray in a slice
    double crossSection = 0;  ///< world area per ray, perpendicular to the direction
    int reach = 0;            ///< voxels met beyond the one at the shift: 0 nearest, 1 linear
    bool periodic = false;    ///< the volume repeats along the sweep's axis, too: rays go from its end to its beginning

    bool rowsUp() const { return row.slope >= 0; }        ///< rows of bricks are met in ascending order
    bool columnsUp() const { return column.slope >= 0; }  ///< and so are the bricks of a row

    /// Number, in the order of travel, of the first slice met of the brick that begins at `brickLow`.
    int sliceNumber(int brickLow) const {
        return ascending ? brickLow - firstSlice : firstSlice - (brickLow + kBrickEdge - 1);
    }
};

/// Where the lattice of rays is in the first slice, in [0,1).
struct LatticeOffset {
    double column = 0, row = 0;
};

/// The front for light that travels along `direction` (unit, world). A fresh random offset in each sweep makes
/// `nearest` unbiased.
RayFront parallelFront(const BrickLayout& layout, const Vec3& direction, int reach, const LatticeOffset& offset,
                       const Periodic& periodic);

/// Half-open range of ray coordinates.
struct RayRange {
    int begin = 0, end = 0;
    bool empty() const { return end <= begin; }
    int size() const { return empty() ? 0 : end - begin; }
};

/// Rays that are within the volume laterally at slice `k`; with a periodic axis all are.
RayRange raysInside(const RayFront& front, const Lateral& lateral, int k);

/// Rays of lattice row `row` that enter the volume somewhere.
RayRange raysThatEnter(const RayFront& front, int row);

/// Number of rays that enter the volume. If it is periodic along the sweep's axis, those that come from its other end
/// do not count.
double countRaysThatEnter(const RayFront& front);

/// All ray coordinates that occur along one lateral axis.
RayRange rayExtent(const RayFront& front, const Lateral& lateral);

/// Power of the rays (and their local furnace) between one repetition of a periodic volume and the next along the
/// sweep's axis; (column, row) are the lattice coordinates they will have there, in the front `nextRepetition`.
struct CrossingRays {
    RayRange columns, rows;
    int channels = 0;
    std::vector<float> power;
    std::vector<float> furnace;  ///< empty if not measured
    std::vector<float> slice;    ///< in which a ray was in a solid last, as the next repetition counts

    CrossingRays() = default;
    CrossingRays(const RayFront& front, int channelCount, bool withFurnace);
    float& at(int channel, int row, int column) {
        return power[std::size_t(channel) * std::size_t(rows.size()) * std::size_t(columns.size()) +
                     index(row, column)];
    }
    float& furnaceAt(int row, int column) { return furnace[index(row, column)]; }
    float& sliceAt(int row, int column) { return slice[index(row, column)]; }

  private:
    std::size_t index(int row, int column) const {
        return std::size_t((row - rows.begin) * columns.size() + column - columns.begin);
    }
};

/// The same rays one repetition on, relabelled so that again a ray is at its own coordinates in the first slice.
RayFront nextRepetition(const RayFront& front);

/// Coordinate in `nextRepetition` of the ray now at `ray`; it is outside of `CrossingRays` if the ray has left by then.
int rayInNextRepetition(const RayFront& front, const Lateral& lateral, int ray);

}  // namespace raysweep
