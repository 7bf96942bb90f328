/// Volumes made from nothing, for demonstrations and tests.
#pragma once

#include "raysweep/volume/grids.h"

#include <cstdint>

namespace raysweep {

/// Common to all phantoms. They are fog volumes called "density", 0 outside, centred at the world's origin.
struct PhantomOptions {
    int size = 128;                ///< longest edge of the object's box, voxels, in [2,4096]
    double voxelSize = 0;          ///< edge of a voxel, world units; 0: such that the longest edge is 2 units
    float density = 1;             ///< largest density, > 0
    double soft = 1;               ///< sphere: width over which the density falls from full to 0, voxels, in [0,size/2]
    openvdb::Coord dims{0, 0, 0};  ///< box: voxels along x, y, z; all 0: a cube of `size`
    std::uint32_t seed = 1;        ///< cloud

    /// @throw InvalidArgument naming field, value and bound.
    void validate() const;
};

/// A cumulus: billowing balls on a flattened base (z is up), soft at its edges.
/// The same options give the same bits, whatever the number of threads.
openvdb::FloatGrid::Ptr makeCloud(const PhantomOptions& options);

/// A ball that touches the box of `size` voxels where its density becomes 0. Its density falls linearly from full to 0
/// within `soft` voxels; half of it is reached at the radius (size - soft)/2 voxels. With soft = 0, a voxel is full if
/// its centre is inside.
openvdb::FloatGrid::Ptr makeSphere(const PhantomOptions& options);

/// A box of constant density; its first voxel has the index (0,0,0).
openvdb::FloatGrid::Ptr makeBox(const PhantomOptions& options);

}  // namespace raysweep
