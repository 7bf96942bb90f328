/// Joseph's projector: the line integral of a ray from samples of the volume, one in each slice across the ray's major
/// axis. P. M. Joseph, "An Improved Algorithm for Reprojecting Rays through Pixel Images", IEEE Transactions on Medical
/// Imaging 1(3), 1982, in three dimensions. A ray that is at (y, z) in slice s sees there the four voxels around it,
///
///     p = (A x) = len Σ_s Σ_j Σ_k w_j(y) w_k(z) x[s, j, k],   w_j(y) = max(0, 1 − |y − j|)                  (1)
///
/// (docs/ct.md, eq. 1), y, z in voxels, len: the ray's length from slice to slice, world units. Every w of projector
/// and backprojector is that of LateralWeights, so that one is the other's adjoint; whole vectors of rows take theirs
/// from column_kernels-inl.h, which has the same formula in lanes.
#pragma once

#include "raysweep/camera/projection_geometry.h"
#include "raysweep/projector/column_volume.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace raysweep {

/// Joseph's weights along one axis across the ray, w of eq. 1: of the two voxels beside it; all others have 0.
struct LateralWeights {
    int below;    ///< the voxel at the ray or below it; the other is `below` + 1
    float lower;  ///< weight of voxel `below`
    float upper;  ///< of voxel `below` + 1; the two sum to 1
};

/// @param place of the ray along the axis, voxels; voxel j's centre is at j
template <class Real>
LateralWeights besideRay(Real place) {
    const int below = int(std::floor(place));
    const float upper = float(place - Real(below));
    return {below, 1 - upper, upper};
}

/// Indices [first, last): slices, or detector columns.
struct IndexRange {
    int first = 0, last = 0;
};

/// The rows of one detector column where they cross a column of voxels: row v at z = height + pitch v, pitch > 0.
struct DetectorRows {
    float height, pitch;
    int count;

    float at(int row) const { return height + pitch * float(row); }

    /// The first of the rows that may lie above z: none before it does.
    int firstAbove(float z) const { return int(std::floor(std::clamp((z - height) / pitch, -1e6f, 1e6f))); }
};

/// The rays of one detector column in a view whose detector rows follow the volume's columns: seen along the columns
/// they are one line. In slice s they lie at `lateral`, and the ray of row v at z = height0 + height1 s + (pitch0 +
/// pitch1 s) v.
struct DetectorColumn {
    int axis = 0;                       ///< the major axis: 0 (slices of constant x, lateral y) or 1
    double lateral0 = 0, lateral1 = 0;  ///< lateral = lateral0 + lateral1 s
    double height0 = 0, height1 = 0, pitch0 = 0, pitch1 = 0;
    double length0 = 0, length1 = 0,
           length2 = 0;  ///< length per slice of row v: sqrt(length0 + v (length1 + v length2))
    IndexRange slices;   ///< that lie in the volume, before the source
    int rowCount = 0;

    double lateral(int slice) const { return lateral0 + lateral1 * slice; }
    /// The columns of voxels beside the rays in a slice: voxel (slice, below), and the next.
    LateralWeights beside(int slice) const { return besideRay(lateral(slice)); }
    int voxelX(int slice, int across) const { return axis == 0 ? slice : across; }
    int voxelY(int slice, int across) const { return axis == 0 ? across : slice; }
    DetectorRows rows(int slice) const {
        return {float(height0 + height1 * slice), float(pitch0 + pitch1 * slice), rowCount};
    }
    float length(int row) const { return float(std::sqrt(length0 + row * (length1 + row * length2))); }
};

/// The rays of one detector column in a slice that they cross along a leaning line (rolled.h).
struct LeaningRows {
    float a, b, c, d;    ///< row v is at z = (a + b v) / (c + d v)
    float offset, lean;  ///< at lateral = offset + lean z

    float at(float row) const { return (a + b * row) / (c + d * row); }
    float rowAt(float z) const { return (a - z * c) / (z * d - b); }
    float lateral(float z) const { return offset + lean * z; }
    /// From row v to the next, voxels.
    float pitch(float row) const { return (b * c - a * d) / ((c + d * row) * (c + d * row)); }
};

/// The rays of one detector column in a view whose detector is rolled or tilted.
struct RolledColumn {
    int axis = 0;                           ///< the major axis: 0 or 1, as DetectorColumn's
    double a0 = 0, a1 = 0, b0 = 0, b1 = 0;  ///< a = a0 + a1 s, b = b0 + b1 s in slice s
    double c = 1, d = 0;
    double offset0 = 0, offset1 = 0, lean = 0;     ///< offset = offset0 + offset1 s
    double length0 = 0, length1 = 0, length2 = 0;  ///< of row v: sqrt(length0 + v (length1 + v length2)) / |c + d v|
    IndexRange slices;                             ///< before the source

    LeaningRows rows(int slice) const {
        return {float(a0 + a1 * slice),
                float(b0 + b1 * slice),
                float(c),
                float(d),
                float(offset0 + offset1 * slice),
                float(lean)};
    }
    double lateral(int slice, double z) const { return offset0 + offset1 * slice + lean * z; }
    int voxelX(int slice, int across) const { return axis == 0 ? slice : across; }
    int voxelY(int slice, int across) const { return axis == 0 ? across : slice; }
    float length(int row) const {
        return float(std::sqrt(length0 + row * (length1 + row * length2)) / std::abs(c + d * row));
    }
};

/// Detector columns that share their major axis and the sense in which they cross its slices.
struct DetectorColumnRun {
    IndexRange columns;
    int axis = 0;
};

/// A view in the coordinates of a volume's voxels. Its rows are those of the detector or, if the detector lies on its
/// side, the detector's columns: whichever follow the volume's columns better.
struct JosephView {
    enum class Kind {
        level,    ///< each ray stays at one z
        upright,  ///< each detector column lies in a plane that contains the volume's columns
        rolled,   ///< each detector column leans against the volume's, by less than half a right angle or so
        oblique   ///< anything else: each ray is for itself
    };
    Kind kind = Kind::oblique;
    BeamShape beam = BeamShape::parallel;
    int width = 0, height = 0;
    bool onSide = false;   ///< columns are the detector's rows, and rows its columns
    bool flipped = false;  ///< rows are counted from the last to the first, so that z grows with them
    XrayView xray;         ///< voxel coordinates, columns and rows counted as above
    Matrix3 worldFromVoxel;
    std::vector<DetectorColumn> columns;  ///< each detector column, if level or upright
    std::vector<RolledColumn> rolled;     ///< each detector column, if rolled
    std::vector<DetectorColumnRun> runs;

    /// Where the ray of a column and a row is among the view's values (Projections).
    std::size_t pixel(int column, int row) const {
        const std::size_t u = std::size_t(column), v = std::size_t(flipped ? height - 1 - row : row);
        return onSide ? u * std::size_t(height) + v : v * std::size_t(width) + u;
    }
};

JosephView josephView(const ProjectionGeometry& geometry, int view, const ColumnLattice& lattice);

/// The index axis (0, 1, 2) of a grid that columns should run along: the one that detector rows, or the columns of
/// detectors on their side, follow best.
int columnAxisFor(const ProjectionGeometry& geometry, const openvdb::math::Transform& transform);

/// One ray for itself: in slice s of `axis` it is at (lateral0 + lateral1 s), the other two axes in ascending order.
struct RayLine {
    int axis = 0;
    double lateral0[2] = {0, 0}, lateral1[2] = {0, 0};
    float length = 0;  ///< from slice to slice, world units
    IndexRange slices;

    /// Along the first (0) or the second (1) of the other axes.
    LateralWeights beside(int other, int slice) const { return besideRay(lateral0[other] + lateral1[other] * slice); }
};

RayLine rayLine(const JosephView& view, const Index3& dims, int column, int row);

}  // namespace raysweep
