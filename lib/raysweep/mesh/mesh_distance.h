/// Distances to triangles, on voxels near them.
#pragma once

#include "raysweep/core/progress.h"
#include "raysweep/mesh/triangle_mesh.h"
#include "raysweep/volume/grids.h"

namespace raysweep {

/// Voxels in space: (i,j,k) covers origin + voxel * [i,i+1) x [j,j+1) x [k,k+1).
struct MeshLattice {
    Vec3 origin{0};    ///< world units
    double voxel = 1;  ///< edge, world units

    openvdb::math::Transform::Ptr transform() const;
};

/// Some triangles of a mesh.
struct MeshPart {
    const TriangleMesh& mesh;
    std::vector<std::uint32_t> triangles;  ///< indices
};

/// World units, up to `band` voxels from the triangles.
struct MeshDistance {
    openvdb::FloatGrid::Ptr distance;  ///< below 0 inside if it is signed; null if stopped
    openvdb::Int32Grid::Ptr nearest;   ///< which triangle of the part is nearest
};

MeshDistance unsignedDistance(const MeshPart& part, const MeshLattice& lattice, double band,
                              const ProgressCallback& progress = {});

/// What closed shells enclose is inside. @param part shells that are closed, and face alike within each
MeshDistance signedDistance(const MeshPart& part, const MeshLattice& lattice, double band,
                            const ProgressCallback& progress = {});

/// Corners in the lattice's index space, moved aside by less than a thousandth of a voxel, so that hardly a voxel's
/// centre lies on a face.
std::vector<openvdb::Vec3s> latticePoints(const TriangleMesh& mesh, const MeshLattice& lattice);

}  // namespace raysweep
