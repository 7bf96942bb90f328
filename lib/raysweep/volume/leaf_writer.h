/// Grids that are compressed by all threads.
#pragma once

#include "raysweep/volume/grids.h"

namespace raysweep {

/// A copy of `grid`, with metadata of its own, that an archive writes faster: the same tree, the same bytes. OpenVDB
/// compresses leaf after leaf in one thread, which is most of the time that writing takes. Float and vec3s grids only;
/// others are written as fast as ever.
openvdb::GridBase::Ptr writtenInParallel(const openvdb::GridBase::ConstPtr& grid);

}  // namespace raysweep
