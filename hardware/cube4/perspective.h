/// Fronts of rays from a point, an eye or an X-ray source: what the paper leaves open for cone beams.
///
/// In the slice at distance D from the point, ray (i,j) is at (a + (phaseU + i s) D, b + (phaseV + j s) D): its place
/// along u does not depend on j, nor that along v on i. Rays diverge. Where they come closer than `leastSpacing` voxels
/// every other one is left out, where they are two voxels apart each is split into two, along u and v: so the volume is
/// passed in regions whose bounds are at distances that double (Kreeger et al. 1998, US patent 6674430).
///
/// A voxel has one ray at most. Where rays are closer than a voxel the region is passed several times, by every other
/// ray at a time.
#pragma once

#include "cube4/dense_volume.h"
#include "cube4/ray_buffer.h"
#include "cube4/traversal.h"

#include <vector>

namespace raysweep::cube4 {

/// Rays from a point to the pixels of a picture or a detector. World units.
struct PointRays {
    Vec3 source{0};
    Vec3 origin{0}, column{0}, row{0};  ///< centre of pixel (0,0), and from it to the next
    int width = 0, height = 0;
};

/// The volume as it is in memory.
struct MemoryBox {
    DenseBox box;
    Vec3 origin{0};  ///< world position of the centre of voxel `box.low`
    int pad = 1;     ///< empty voxels around the box

    Index3 size() const { return box.size() + Index3(2 * pad); }
};

/// How closely rays are set.
struct RaySampling {
    double leastSpacing =
        0.5;                  ///< voxels, in [0.01,1]: closer ones are merged. Below 1 slices are passed several times
    double raysPerPixel = 1;  ///< along u, and along v; in [1,64]

    /// @throw InvalidArgument naming field, value and bound
    void validate() const;
};

/// Lattice coordinates of rays, inclusive.
struct LatticeRange {
    int lowU = 0, highU = -1, lowV = 0, highV = -1;
};

/// Slices that are passed with one lattice of rays.
struct Region {
    int first = 0, end = 0;  ///< slices, counted from that of the box which is next to the point; end exclusive
    int level = 0;           ///< rays are 2^level times as far apart as the lattice asked for
    int sublattices = 1;     ///< along u, and along v: passes of its own
};

/// Rays that have one major axis.
struct PerspectiveFront {
    int major = 2, axisU = 1, axisV = 0;  ///< memory axes, as in Traversal
    bool up = true;                       ///< rays go up the major axis
    Vec3 apex{0};                         ///< the point, memory coordinates
    double spacing = 1;                   ///< change of slope from a ray to the next at level 0
    double phaseU = 0, phaseV = 0;        ///< slopes of ray (0,0)
    std::vector<Region> regions;          ///< from the point on
    LatticeRange range;                   ///< at the last region's level

    double spacingAt(int level) const { return std::ldexp(spacing, level); }
    /// At a level.
    LatticeRange rangeAt(int level) const;
    /// Way of ray (u,v) of a level, memory: 1 along the major axis.
    Vec3 wayOf(double u, double v, int level) const;
    /// Lattice coordinates at a level of the ray that goes along `way`.
    Imath::V2d rayOf(const Vec3& way, int level) const;
    /// Whether a ray along `way`, memory, is one of this front's.
    bool has(const Vec3& way) const { return majorAxis(way) == major && (way[major] > 0) == up; }
    /// World length of a ray along `way` in a slice, and that of the longest ray.
    double lengthOf(const Vec3& way, const Matrix3& worldFromIndex) const;
    double longest(const Matrix3& worldFromIndex) const;
    /// Memory coordinate of slice n of Region.
    int sliceAt(int n, const MemoryBox& memory) const;
};

/// The fronts of a picture's rays that meet the volume: one for each major axis and sense that they have.
/// @throw InvalidArgument if pixels have no area
std::vector<PerspectiveFront> frontsOf(const PointRays& pixels, const MemoryBox& memory, const RaySampling& sampling);

/// Pixels of rays.
class PointPlane {
  public:
    PointPlane(const PointRays& pixels, const MemoryBox& memory);

    /// Way of a pixel's ray, memory.
    Vec3 wayOf(double column, double row) const { return first_ + columns_ * column + rows_ * row; }
    /// Pixel coordinates of the ray along `way`; NaN if it does not meet the plane.
    Imath::V2d pixelOf(const Vec3& way) const;
    const Vec3& apex() const { return apex_; }

  private:
    Vec3 apex_, first_, columns_, rows_;  ///< memory
    Matrix3 pixelFromWay_;
};

enum class RayOrder {
    diverging,  ///< away from the point
    converging  ///< towards it
};

/// How a front goes through the volume.
struct Journey {
    const PerspectiveFront& front;
    const MemoryBox& memory;
    RayOrder order = RayOrder::diverging;
    int ending = 1;        ///< as in slicesOf
    bool settles = false;  ///< the last pass over a region goes over all of its voxels, not only where rays are
};

/// One pass over a region.
template <class Weight>
struct RegionPass {
    Traversal traversal;
    std::vector<SliceSetup<Weight>> slices;
    bool lastOfRegion = true;
    bool grouped = false;  ///< the region has several
};

/// @param sublattice from (0,0) to below `region.sublattices`
template <class Arithmetic>
RegionPass<typename Arithmetic::Weight> regionPass(const Arithmetic& arithmetic, const Journey& journey,
                                                   const Region& region, const Imath::V2i& sublattice);

/// Room for all rays of a front at a level.
template <class Word>
RayPlane<Word> planeOf(const LatticeRange& range, const Ray<Word>& each = {}) {
    RayPlane<Word> plane;
    plane.lowU = range.lowU, plane.width = range.highU - range.lowU + 1;
    plane.lowV = range.lowV, plane.height = range.highV - range.lowV + 1;
    plane.rays.assign(std::size_t(plane.width) * std::size_t(plane.height), each);
    return plane;
}

}  // namespace raysweep::cube4
