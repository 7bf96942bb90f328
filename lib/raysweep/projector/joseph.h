/// Where the rays of an X-ray view run through a volume of columns, slice by slice: Joseph's footprint. P. M. Joseph,
/// "An Improved Algorithm for Reprojecting Rays through Pixel Images", IEEE Transactions on Medical Imaging 1(3), 1982.
/// A ray meets each slice perpendicular to its major axis in one point, and there the four voxels around it with
/// bilinear weights; its line integral is their sum times the ray's length from slice to slice. Projector and
/// backprojector both take their weights from here, so that one is the other's adjoint.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/projector/column_volume.h"

#include <cmath>
#include <vector>

namespace raysweep {

/// Slices [first, last) that a ray meets.
struct SliceRange {
    int first = 0, last = 0;
};

/// The rays of one detector column in a view whose detector rows follow the volume's columns: seen along the columns
/// they are one line. In slice s they lie at `lateral`, and the ray of row v at z = height0 + height1 s + (pitch0 +
/// pitch1 s) v.
struct FanLine {
    int axis = 0;                       ///< the major axis: 0 (slices of constant x, lateral y) or 1
    double lateral0 = 0, lateral1 = 0;  ///< lateral = lateral0 + lateral1 s
    double height0 = 0, height1 = 0, pitch0 = 0, pitch1 = 0;
    double length0 = 0, length1 = 0,
           length2 = 0;  ///< length per slice of row v: sqrt(length0 + v (length1 + v length2))
    SliceRange slices;   ///< that lie in the volume, before the source

    double lateral(int slice) const { return lateral0 + lateral1 * slice; }
    float height(int slice) const { return float(height0 + height1 * slice); }
    float pitch(int slice) const { return float(pitch0 + pitch1 * slice); }
    float length(int row) const { return float(std::sqrt(length0 + row * (length1 + row * length2))); }
};

/// Detector columns [first, last) that share their major axis and the sense in which they cross its slices.
struct FanRun {
    int first = 0, last = 0;
    int axis = 0;
};

/// A view in the coordinates of a volume's voxels.
struct ViewFootprint {
    enum class Kind {
        level,    ///< each ray stays at one z
        upright,  ///< each detector column lies in a plane that contains the volume's columns
        oblique   ///< anything else: each ray is for itself
    };
    Kind kind = Kind::oblique;
    BeamShape beam = BeamShape::parallel;
    int width = 0, height = 0;
    bool flipped = false;  ///< rows are counted from the last to the first, so that z grows with them
    XrayView view;         ///< voxel coordinates, rows counted as above
    Matrix3 worldFromVoxel;
    std::vector<FanLine> lines;  ///< of each detector column, unless oblique
    std::vector<FanRun> runs;
};

ViewFootprint footprintOf(const ProjectionGeometry& geometry, int view, const ColumnLattice& lattice);

/// The index axis (0, 1, 2) of a grid that columns should run along: the one that detector rows follow best.
int columnAxisFor(const ProjectionGeometry& geometry, const openvdb::math::Transform& transform);

/// One ray for itself: in slice s of `axis` it is at (lateral0 + lateral1 s), the other two axes in ascending order.
struct RayLine {
    int axis = 0;
    double lateral0[2] = {0, 0}, lateral1[2] = {0, 0};
    float length = 0;  ///< from slice to slice, world units
    SliceRange slices;
};

RayLine rayLine(const ViewFootprint& footprint, const Index3& dims, int column, int row);

}  // namespace raysweep
