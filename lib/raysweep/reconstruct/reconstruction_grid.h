/// Where a volume is reconstructed.
#pragma once

#include "raysweep/camera/camera.h"
#include "raysweep/camera/projection_geometry.h"
#include "raysweep/core/types.h"
#include "raysweep/volume/grids.h"

#include <algorithm>
#include <optional>

namespace raysweep {

constexpr int kMostVoxelsAlong = 1 << 14;  ///< an axis: what is more was hardly meant

/// Voxels along the world's axes; the first has the index (0,0,0).
struct ReconstructionGrid {
    Index3 dims{0};   ///< voxels along x, y, z, > 0
    Vec3 center{0};   ///< middle of the grid, world units
    Vec3 spacing{0};  ///< edges of a voxel along x, y, z, world units, > 0; where they are the same it is a cube

    /// Centre of voxel (i,j,k); need not be whole numbers.
    Vec3 voxel(double i, double j, double k) const {
        return center + Vec3(i - 0.5 * (dims.x - 1), j - 0.5 * (dims.y - 1), k - 0.5 * (dims.z - 1)) * spacing;
    }

    /// All of its voxels, world units.
    Box3 box() const {
        const Vec3 half = 0.5 * size();
        return Box3(center - half, center + half);
    }

    /// From its first voxel's outer faces to those of the last, world units.
    Vec3 size() const { return Vec3(dims.x, dims.y, dims.z) * spacing; }

    /// Edge of voxels that are cubes, world units.
    double edge() const { return spacing.x; }
    bool hasCubes() const { return spacing == Vec3(spacing.x); }
    double shortestEdge() const { return std::min({spacing.x, spacing.y, spacing.z}); }

    /// Voxels along the longest edge.
    int resolution() const { return std::max({dims.x, dims.y, dims.z}); }

    /// Index to world space.
    openvdb::math::Transform::Ptr transform() const;

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;

    /// For what knows no other voxels. @throw InvalidArgument if they are no cubes.
    void requireCubes() const;
};

/// The edge of voxels that are cubes along the world's axes; nothing if they are not.
std::optional<double> edgeOfCubes(const openvdb::math::Transform& transform);

/// All that the detector sees of an object that turns: about the part of the axis that is seen, as wide as the rays at
/// the detector's sides are away from the axis in any view; voxels as large as the smaller edge of a pixel is at the
/// axis. @throw InvalidArgument if the views are not those of a turn about an axis, as fitOrbit, or if more than
/// kMostVoxelsAlong voxels along an axis were needed.
ReconstructionGrid coveringGrid(const ProjectionGeometry& geometry);

/// What is asked of a grid; see reconstructionGrid for what is not.
struct GridOptions {
    std::optional<Index3> dims;   ///< voxels along x, y, z, 1 to kMostVoxelsAlong
    std::optional<Vec3> spacing;  ///< edges of a voxel along x, y, z, world units, > 0
    std::optional<Vec3> center;   ///< middle of the grid, world units

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// The grid that was asked for. What was not is that of `frame`'s active voxels, else all that the detector sees
/// (coveringGrid); with `dims` and no frame the middle is that of what the detector sees or, if the views are no turn,
/// where the rays through the detector's middle come closest to each other; with `spacing` alone the extent stays. The
/// grid of a frame that is not moved to `center` is moved by less than a voxel, so that voxels lie on those of the
/// frame.
/// @param frame a volume with active voxels; may be null.
/// @throw InvalidArgument as GridOptions::validate and coveringGrid; if what the detector sees must be known, but the
/// views are not those of a turn; for a frame of voxels that are no cubes and do not lie along the world's axes, unless
/// `dims` and `spacing` are given.
ReconstructionGrid reconstructionGrid(const ProjectionGeometry& geometry, const GridOptions& options,
                                      const openvdb::FloatGrid* frame = nullptr);

}  // namespace raysweep
