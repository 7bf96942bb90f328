/// From meshes to volumes.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/mesh/mesh_shells.h"
#include "raysweep/volume/grids.h"

#include <optional>

namespace raysweep {

struct MeshVolumeOptions {
    std::optional<double> voxelSize;  ///< edge of a voxel, world units, above 0; places of different meshes then agree
    int size = 128;                   ///< else: voxels along the longest side of the meshes' box, in [1, 65536]
    double thickness = 2;             ///< of sheets, voxels, above 0; thinner ones than a voxel let light through
    std::string name = "density";     ///< of the grid, not empty

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

struct MeshVolume {
    openvdb::FloatGrid::Ptr density;  ///< part of a voxel that is inside, in [0,1]: 1/2 on the surface; null if stopped
    openvdb::Vec3SGrid::Ptr
        color;                ///< "Cd", wherever density is and a few voxels beyond; null if the mesh has no colours
    MeshShells shells;        ///< what the mesh is made of
    std::size_t solids = 0;   ///< closed shells that face outwards
    std::size_t inwards = 0;  ///< closed shells that face inwards
    std::size_t sheets = 0;   ///< open shells, which were given a thickness
    double thickness = 0;     ///< of sheets, voxels
    std::size_t thin = 0;     ///< closed shells thinner than a voxel on average: light comes through
};

/// Fills closed shells; one that faces inwards is a cavity where it lies within others that do not, and else filled,
/// too. Triangles that face otherwise than their shell are turned. Open shells are given a thickness, half of it on
/// either side. Density falls from 1 to 0 within one voxel across the surface. Colours are those of the nearest place
/// on the mesh. Of what overlaps the denser counts. Index (0,0,0) lies at the low corner of the meshes' box; with a
/// given voxel size voxels lie between multiples of it. Asks `progress` now and then, and stops with no density if told
/// to.
/// @throw InvalidArgument for options out of bounds, a mesh without extent, more than 65536 voxels along a side, or
/// more than the machine's memory holds
MeshVolume meshToVolume(const TriangleMesh& mesh, const MeshVolumeOptions& options = {},
                        const ProgressCallback& progress = {});

}  // namespace raysweep
