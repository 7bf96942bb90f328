/// Grids of types that Raysweep does not work with.
#pragma once

#include "raysweep/volume/grids.h"

#include <memory>

namespace raysweep::test {

/// An empty grid, made by OpenVDB's library: GridType::create would compile all of its tree here, which takes seconds.
template <class GridType>
typename GridType::Ptr otherGrid() {
    initializeGrids();
    return std::static_pointer_cast<GridType>(openvdb::GridBase::createGrid(GridType::gridType()));
}

}  // namespace raysweep::test
