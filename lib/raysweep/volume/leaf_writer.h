/// Grids that are compressed by all threads.
#pragma once

#include "raysweep/volume/grids.h"

namespace raysweep {

/// `grid` as one that an archive writes faster: the same name, metadata and tree, the same bytes. OpenVDB compresses
/// leaf after leaf in one thread, which is most of the time that writing takes. Float and vec3s grids only; others are
/// returned as they are.
openvdb::GridBase::ConstPtr writtenInParallel(const openvdb::GridBase::ConstPtr& grid);

}  // namespace raysweep
