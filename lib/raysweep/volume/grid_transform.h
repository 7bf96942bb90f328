/// What is asked of grids' transforms.
#pragma once

#include "raysweep/volume/grids.h"

namespace raysweep {

/// @throw InvalidArgument naming the grid if its transform is not linear
void requireLinear(const openvdb::GridBase& grid);

/// @throw InvalidArgument naming both if their transforms differ
void requireSameTransform(const openvdb::GridBase& grid, const openvdb::GridBase& other);

}  // namespace raysweep
