/// How often closed surfaces go round a place.
#pragma once

#include "raysweep/mesh/mesh_distance.h"

namespace raysweep {

/// Counts by rays along z through the voxels' centres: +1 for every surface that is entered from its front, -1 for
/// every one that is left. So what lies within two solids is inside, and so is what a surface encloses that faces
/// inwards, but not what such a surface encloses within a solid.
class MeshWinding {
  public:
    MeshWinding(const MeshPart& part, const MeshLattice& lattice);

    int numberAt(const openvdb::Coord& voxel) const;

  private:
    /// Of a ray and a triangle.
    struct Crossing {
        std::int32_t x, y;
        float z;
        int sign;
    };
    static bool isBefore(const Crossing& a, const Crossing& b);
    void add(const openvdb::Vec3s (&corners)[3]);

    std::vector<Crossing> crossings_;  ///< ray after ray, along z
};

}  // namespace raysweep
