/// Where a ray can meet anything at all.
#pragma once

#include "raysweep/volume/grids.h"

namespace raysweep {

/// A tree whose active tiles of 8^3 voxels or more cover every point at which `density`, interpolated linearly between
/// voxel centres, can differ from 0. It has no leaves: 8 bytes per block, whatever the density holds. In this tree's
/// eyes voxel (i,j,k) is the cell [i,i+1) x [j,j+1) x [k,k+1) between eight centres, as math::VolumeHDDA assumes.
/// Active tiles of `density` count as its voxels do. All values are kNoBlock (cell_blocks.h).
openvdb::Int32Tree::Ptr occupancy(const openvdb::FloatGrid& density);
openvdb::Int32Tree::Ptr occupancy(const openvdb::Vec3SGrid& emission);

/// `density` itself if it is 0 wherever it is inactive, else a copy in which it is. A level set or a careless tool may
/// leave other values there; they are no medium.
openvdb::FloatGrid::ConstPtr zeroWhereInactive(const openvdb::FloatGrid::ConstPtr& density);
openvdb::Vec3SGrid::ConstPtr zeroWhereInactive(const openvdb::Vec3SGrid::ConstPtr& emission);

}  // namespace raysweep
